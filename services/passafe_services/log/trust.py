"""Trust in who signed a log: is the certificate the recorder's, and of the authority that the reader trusts?"""

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

from cryptography import x509
from passafe_protocol.identity import Identity

from passafe_services.keys.credentials import identity_of
from passafe_services.keys.errors import KeysUnreadableError
from passafe_services.keys.key_files import is_issued_by, read_certificate
from passafe_services.keys.signing import fingerprint, is_signed_by

ROLE = "recorder"


@dataclass(frozen=True, kw_only=True, slots=True)
class LogSigner:
    """Holder of the key that signed a log, by the certificate in it.

    Attributes:
        certificate: The certificate.
        holder: Its holder.
        fingerprint: Its SHA-256 fingerprint.
        doubt: Why the signatures prove nothing to the reader; empty if nothing stands against them.
        is_pinned: Whether the reader named the authority, or the certificate itself.
    """

    certificate: x509.Certificate
    holder: Identity
    fingerprint: str
    doubt: str
    is_pinned: bool

    @classmethod
    def of(cls, record: Mapping[str, str], pinned: Path | None) -> Self | None:
        """Return the signer that a log names; ``None`` if it names none.

        Args:
            record: Metadata record of the signer.
            pinned: Certificate of the authority that the reader trusts, or of the recorder itself; ``None``: the log is
                believed about its authority.

        Raises:
            KeysError: ``pinned`` is no certificate.
        """
        trusted = None if pinned is None else read_certificate(pinned)
        try:
            certificate = x509.load_pem_x509_certificate(record.get("certificate", "").encode())
            own_authority = x509.load_pem_x509_certificate(record.get("authority", "").encode())
            holder = identity_of(certificate, Path("the log's certificate"))
        except (ValueError, KeysUnreadableError):
            return None
        doubt = ""
        authority = own_authority if trusted is None else trusted
        if certificate != trusted and not is_issued_by(certificate, authority):
            doubt = f"its certificate, of {holder.common_name}, is not of the authority {pinned or 'in the log'}"
        elif holder.role != ROLE:
            doubt = f"it is signed by {holder.common_name}, which is no recorder"
        return cls(
            certificate=certificate,
            holder=holder,
            fingerprint=fingerprint(certificate),
            doubt=doubt,
            is_pinned=trusted is not None,
        )

    def has_signed(self, body: str, signature: bytes) -> bool:
        """Check the signature of a checkpoint."""
        return is_signed_by(self.certificate, body.encode(), signature)

    def was_valid(self, wall_ns: int) -> bool:
        """Return whether the certificate was valid at a log time, ns."""
        at = datetime.fromtimestamp(min(wall_ns // 1_000_000_000, 2**37), UTC)
        return self.certificate.not_valid_before_utc <= at <= self.certificate.not_valid_after_utc
