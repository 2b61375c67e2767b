"""Find out why no session with a router comes about: Zenoh only says that none did."""

import socket
import ssl
from typing import Final

from passafe_services.loop.router_endpoint import RouterEndpoint

TIMEOUT_S: Final = 1.0

_REFUSAL_OF_ALERT: Final = {
    "CERTIFICATE_EXPIRED": "the router says that this certificate has expired",
    "UNKNOWN_CA": "the router does not know the authority of this certificate: are these keys of its deployment?",
    "DECRYPT_ERROR": "the router does not accept this certificate: are these keys of its deployment?",
    "BAD_CERTIFICATE": "the router does not accept this certificate: are these keys of its deployment?",
    "CERTIFICATE_REQUIRED": "the router asks for a certificate: give --keys",
}


def refusal_of(endpoint: RouterEndpoint) -> str:
    """Return why a TLS handshake with a router fails, in words; empty if nobody listens or it does not fail."""
    credentials = endpoint.credentials
    try:
        with socket.create_connection((endpoint.host, endpoint.port), timeout=TIMEOUT_S) as connection:
            if credentials is None:
                return _speaks_tls(connection)
            context = ssl.create_default_context(cafile=str(credentials.folder.authority))
            context.load_cert_chain(credentials.folder.certificate, credentials.folder.key)
            with context.wrap_socket(connection, server_hostname=endpoint.host) as secured:
                secured.recv(1)  # the other side judges our certificate after our side of the handshake
    except ssl.SSLCertVerificationError as error:
        return f"the router's certificate is refused: {error.verify_message}"
    except ssl.SSLError as error:
        alert = str(error.reason or error)
        known = (text for name, text in _REFUSAL_OF_ALERT.items() if name in alert)
        return next(known, f"no TLS session comes about ({alert}): was the router started with --insecure?")
    except OSError:
        return ""
    return ""


def _speaks_tls(connection: socket.socket) -> str:
    """Return a refusal if the other side begins a TLS handshake."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE  # nothing is sent: only whether it speaks TLS
    try:
        with context.wrap_socket(connection):
            return "the router speaks TLS only: give --keys"
    except (ssl.SSLError, OSError):
        return ""
