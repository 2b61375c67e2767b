"""Access to the page: a token and TLS wherever others than this host can reach it."""

import re
import secrets
import socket
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from passafe_protocol.identity import ROUTER, Identity
from passafe_services.keys.authority import Authority
from passafe_services.keys.key_files import CERTIFICATE_MODE, KEY_MODE, write_file

from passafe_dashboard.address import is_loopback
from passafe_dashboard.errors import PageAccessError

LEAST_TOKEN: Final = 16
"""Characters of a token: fewer could be tried."""

DAYS: Final = 30.0
"""How long a certificate that is made at the start is valid."""

NEW: Final = "new"
"""In the place of a token: one is made."""

_TOKEN: Final = re.compile(rf"[A-Za-z0-9_-]{{{LEAST_TOKEN},}}")

MEMORY: Final = Path("/dev/shm")  # noqa: S108 - the folder below it is this user's alone
"""Where private keys are written for the moment of a start, if there is such a place: it is on no disk."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PageAccess:
    """Condition of access to the page.

    Attributes:
        token: What a browser or program has to know; empty: nothing.
        is_made: Whether the token was made at this start, so that it has to be shown.
        is_encrypted: Whether the page speaks TLS.
        certificate: Certificate with its chain, PEM; ``None``: one is made at the start.
        key: Its private key, PEM.
    """

    token: str = ""
    is_made: bool = False
    is_encrypted: bool = False
    certificate: Path | None = None
    key: Path | None = None

    @classmethod
    def of(
        cls,
        host: str,
        *,
        token: str = "",
        certificate: Path | None = None,
        key: Path | None = None,
        is_open: bool = False,
    ) -> "PageAccess":
        """Return the access to a page that listens at an address: open on loopback, else by token over TLS.

        Args:
            host: Address that it listens on.
            token: Token to ask for, or ``new`` for one that is made; empty: one is made where one is needed.
            certificate: Certificate to show.
            key: Its private key.
            is_open: Whether to do without both: something in front of the page sees to them.

        Raises:
            PageAccessError: Options that do not go together, or a token that can be guessed.
        """
        if (certificate is None) != (key is None):
            raise PageAccessError("--page-certificate", "one file", "--page-certificate and --page-key together")
        if is_open and (token or certificate):
            raise PageAccessError("--open-page", "a token or a certificate too", "one of them")
        if token not in {"", NEW} and not _TOKEN.fullmatch(token):
            allowed = f"{NEW}, or at least {LEAST_TOKEN} letters, digits, - and _"
            raise PageAccessError("--page-token", f"{len(token)} characters", allowed)
        is_exposed = not is_open and host.lower() != "localhost" and not is_loopback(host)
        is_made = token == NEW or (is_exposed and not token)
        return cls(
            token=secrets.token_urlsafe(24) if is_made else token,
            is_made=is_made,
            is_encrypted=is_exposed or certificate is not None,
            certificate=certificate,
            key=key,
        )

    def address(self, host: str, port: int) -> str:
        """Return the address to open; a token that somebody chose is not repeated."""
        shown = f"[{host}]" if ":" in host else host
        query = f"?token={self.token if self.is_made else '…'}" if self.token else ""
        return f"{'https' if self.is_encrypted else 'http'}://{shown}:{port}/{query}"


@dataclass(frozen=True, kw_only=True, slots=True)
class ShownCertificate:
    """Certificate that the page's server shows.

    Attributes:
        certificate: File with it, PEM.
        key: File with its private key, PEM.
        fingerprint: SHA-256 of one that was made at this start, as browsers show it; empty for one that was given.
    """

    certificate: Path
    key: Path
    fingerprint: str = ""


@contextmanager
def shown_certificate(access: PageAccess, hosts: Sequence[str]) -> Iterator[ShownCertificate | None]:
    """Return the certificate to show, made for these hosts if none was given; ``None`` without TLS.

    Files that are made are deleted at the end of the block; a server has read them then.
    """
    if not access.is_encrypted:
        yield None
    elif access.certificate is not None and access.key is not None:
        yield ShownCertificate(certificate=access.certificate, key=access.key)
    else:
        names = dict.fromkeys((*hosts, socket.gethostname()))
        pair = Authority.create(DAYS).issue(Identity(role=ROUTER, name="page"), hosts=tuple(names), days=DAYS)
        digest = x509.load_pem_x509_certificate(pair.certificate).fingerprint(hashes.SHA256())
        with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as folder:
            shown = ShownCertificate(
                certificate=Path(folder) / "certificate.pem",
                key=Path(folder) / "key.pem",
                fingerprint=digest.hex(":").upper(),
            )
            write_file(shown.certificate, pair.certificate, CERTIFICATE_MODE)
            write_file(shown.key, pair.key, KEY_MODE)
            yield shown
