"""Find out why no session with a router comes about: Zenoh only says that none did."""

import socket
import ssl
from typing import Final

from passafe_services.keys.credentials import Credentials
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
    try:
        connection = socket.create_connection((endpoint.host, endpoint.port), timeout=TIMEOUT_S)
    except OSError:
        return ""
    with connection:
        credentials = endpoint.credentials
        return _speaks_tls(connection) if credentials is None else _refusal(connection, endpoint.host, credentials)


def _refusal(connection: socket.socket, host: str, credentials: Credentials) -> str:
    context = ssl.create_default_context(cafile=str(credentials.folder.authority))
    context.load_cert_chain(credentials.folder.certificate, credentials.folder.key)
    secured = False
    try:
        with context.wrap_socket(connection, server_hostname=host) as session:
            secured = True
            session.recv(1)  # the other side judges our certificate after our side of the handshake
    except ssl.SSLCertVerificationError as error:
        return f"the router's certificate is refused: {error.verify_message}"
    except ssl.SSLError as error:
        alert = str(error.reason or error)
        return next((text for name, text in _REFUSAL_OF_ALERT.items() if name in alert), _no_tls(alert))
    except OSError as error:
        return "" if secured else _no_tls(str(error))
    return ""


def _no_tls(reason: str) -> str:
    return f"no TLS session comes about ({reason}): was the router started with --insecure?"


def _speaks_tls(connection: socket.socket) -> str:
    """Return a refusal if the other side begins a TLS handshake."""
    context = ssl.create_default_context()
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE  # nothing is sent: only whether it speaks TLS
    try:
        with context.wrap_socket(connection):
            return "the router speaks TLS only: give --keys"
    except (ssl.SSLError, OSError):
        return ""
