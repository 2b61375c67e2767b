"""Signatures with the key of a holder, and checks of them."""

from pathlib import Path
from typing import Final, Self

from cryptography import x509
from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec

from passafe_services.keys.credentials import Credentials
from passafe_services.keys.key_files import read_file, read_key

_ALGORITHM: Final = ec.ECDSA(hashes.SHA256())


class Signer:
    """Signs with a private key.

    Args:
        key: The key.
        certificate: Certificate of its holder, PEM.
        authority: Certificate of the authority that issued it, PEM.

    Attributes:
        certificate: As given.
        authority: As given.
    """

    def __init__(self, key: ec.EllipticCurvePrivateKey, *, certificate: str, authority: str) -> None:
        self.certificate = certificate
        self.authority = authority
        self._key = key

    @classmethod
    def of(cls, credentials: Credentials) -> Self:
        """Return the signer with a process's keys.

        Raises:
            KeysError: Its files cannot be read any more.
        """
        folder = credentials.folder
        return cls(read_key(folder.key), certificate=_text(folder.certificate), authority=_text(folder.authority))

    def sign(self, data: bytes) -> bytes:
        """Return the signature of some bytes: ECDSA with SHA-256, DER."""
        return self._key.sign(data, _ALGORITHM)


def is_signed_by(certificate: x509.Certificate, data: bytes, signature: bytes) -> bool:
    """Check a signature of ``Signer`` against the certificate of its holder."""
    try:
        key = certificate.public_key()
        if not isinstance(key, ec.EllipticCurvePublicKey):
            return False
        key.verify(signature, data, _ALGORITHM)
    except (InvalidSignature, UnsupportedAlgorithm, ValueError):
        return False
    return True


def fingerprint(certificate: x509.Certificate) -> str:
    """Return the SHA-256 fingerprint of a certificate, in lowercase hexadecimal digits."""
    return certificate.fingerprint(hashes.SHA256()).hex()


def _text(path: Path) -> str:
    return read_file(path).decode()
