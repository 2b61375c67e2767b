"""Files of keys: one folder for each holder, written so that nobody else can read a private key."""

import os
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec
from passafe_protocol.identity import Identity

from passafe_services.keys.authority import KeyPair
from passafe_services.keys.errors import KeysMissingError, KeysUnreadableError

FOLDER_MODE: Final = 0o700
KEY_MODE: Final = 0o600
CERTIFICATE_MODE: Final = 0o644
_OTHERS: Final = 0o007


@dataclass(frozen=True, kw_only=True, slots=True)
class KeyFolder:
    """Folder with the keys of one holder; it is all that the holder's host needs.

    Attributes:
        path: The folder.
    """

    path: Path

    @property
    def authority(self) -> Path:
        """Certificate of the deployment's authority."""
        return self.path / "ca.pem"

    @property
    def certificate(self) -> Path:
        """Certificate of the holder."""
        return self.path / "certificate.pem"

    @property
    def key(self) -> Path:
        """Private key of the holder."""
        return self.path / "key.pem"

    @property
    def admitted(self) -> Path:
        """Router: common names that it admits, one a line."""
        return self.path / "admitted.txt"

    def write(self, pair: KeyPair, authority: bytes) -> None:
        """Write certificate, key and the authority's certificate; the key is never readable for others."""
        self.path.mkdir(mode=FOLDER_MODE, parents=True, exist_ok=True)
        write_file(self.authority, authority, CERTIFICATE_MODE)
        write_file(self.certificate, pair.certificate, CERTIFICATE_MODE)
        write_file(self.key, pair.key, KEY_MODE)

    def write_admitted(self, identities: list[Identity]) -> None:
        """Write the list of those whom a router admits."""
        text = "".join(f"{identity.common_name}\n" for identity in sorted(identities))
        write_file(self.admitted, text.encode(), CERTIFICATE_MODE)

    def read_admitted(self) -> list[Identity]:
        """Return those whom a router admits.

        Raises:
            KeysMissingError: There is no such list.
            KeysUnreadableError: It cannot be read.
            IdentityError: A line is no common name of ours.
        """
        lines = read_file(self.admitted).decode(errors="replace").splitlines()
        return [Identity.of(line.strip()) for line in lines if line.strip()]


def write_file(path: Path, content: bytes, mode: int) -> None:
    """Replace a file at once by one with this mode from its first byte on."""
    fresh = path.with_name(f".{path.name}.new")
    fresh.unlink(missing_ok=True)
    with os.fdopen(os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    fresh.replace(path)


def read_file(path: Path) -> bytes:
    """Return the content of a file.

    Raises:
        KeysMissingError: There is none.
        KeysUnreadableError: It cannot be read.
    """
    try:
        if not stat.S_ISREG(path.stat().st_mode):  # a pipe would wait, and a device never end
            raise KeysUnreadableError(path, "got a folder, device or pipe, allowed a file")
        return path.read_bytes()
    except FileNotFoundError as error:
        raise KeysMissingError(path) from error
    except OSError as error:
        raise KeysUnreadableError(path, f"cannot be read: {error.strerror}") from error


def read_certificate(path: Path) -> x509.Certificate:
    """Return the certificate in a file.

    Raises:
        KeysMissingError: There is no such file.
        KeysUnreadableError: It is no certificate.
    """
    try:
        return x509.load_pem_x509_certificate(read_file(path))
    except ValueError as error:
        raise KeysUnreadableError(path, "got no certificate, allowed one in PEM form") from error


def read_key(path: Path) -> ec.EllipticCurvePrivateKey:
    """Return the private key in a file.

    Raises:
        KeysMissingError: There is no such file.
        KeysUnreadableError: It is no key for elliptic curves, or everybody on this host can read it.
    """
    content = read_file(path)
    mode = path.stat().st_mode & 0o777
    if mode & _OTHERS:
        raise KeysUnreadableError(path, f"got mode {mode:04o}, allowed 0600 or 0640: everybody here can read this key")
    try:
        key = serialization.load_pem_private_key(content, password=None)
    except (ValueError, TypeError) as error:
        raise KeysUnreadableError(path, "got no private key, allowed one in PEM form without a password") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise KeysUnreadableError(path, "got a key of another kind, allowed one for elliptic curves")
    return key


def is_issued_by(certificate: x509.Certificate, authority: x509.Certificate) -> bool:
    """Check that an authority has signed a certificate."""
    try:
        certificate.verify_directly_issued_by(authority)
    except (ValueError, TypeError, InvalidSignature):
        return False
    return True
