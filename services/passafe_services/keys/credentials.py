"""Credentials of a process: its keys, checked before it opens a session."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from cryptography import x509
from cryptography.x509.oid import NameOID
from passafe_protocol.errors import IdentityError, RobotNameError
from passafe_protocol.identity import ROUTER, Identity

from passafe_services.keys.errors import (
    ForeignKeysError,
    KeysExpiredError,
    KeysMismatchError,
    KeysMissingError,
    KeysUnreadableError,
)
from passafe_services.keys.key_files import KeyFolder, is_issued_by, read_certificate, read_key

EXPIRES_SOON_DAYS: Final = 30.0


@dataclass(frozen=True, kw_only=True, slots=True)
class Credentials:
    """Keys with which a process opens sessions, or a router listens; made by ``load_credentials``.

    Attributes:
        identity: Who it is.
        folder: Its files.
        ends: When its certificate ceases to be valid.
    """

    identity: Identity
    folder: KeyFolder
    ends: datetime

    def days_left(self, now: datetime | None = None) -> float:
        """Return for how many days its certificate is still valid."""
        return (self.ends - (now or datetime.now(UTC))).total_seconds() / 86_400


def load_credentials(path: Path, role: str, robot: str = "", *, now: datetime | None = None) -> Credentials:
    """Load and check the keys of a process.

    Args:
        path: Folder of the holder's keys, or of the deployment with one folder for each holder.
        role: Role that the process has.
        robot: Robot that it belongs to; empty for a router.
        now: Time to check the certificate at; the wall clock's if not given.

    Raises:
        KeysMissingError: A file is missing.
        KeysUnreadableError: A file cannot be read or is no such file, key and certificate do not fit, or everybody on
            this host can read the key.
        KeysExpiredError: The certificate is not valid now.
        ForeignKeysError: Another authority has signed the certificate.
        KeysMismatchError: The certificate is of another role or robot.
    """
    wanted = Identity(role=role, robot="" if role == ROUTER else robot)
    folder = _holder_folder(path, wanted)
    certificate, authority = read_certificate(folder.certificate), read_certificate(folder.authority)
    identity = identity_of(certificate, folder.certificate)
    if (identity.role, identity.robot) != (wanted.role, wanted.robot):
        raise KeysMismatchError(folder.certificate, identity.common_name, f"one for {wanted.common_name}")
    if not is_issued_by(certificate, authority):
        raise ForeignKeysError(folder.certificate)
    at = now or datetime.now(UTC)
    for each, file in ((certificate, folder.certificate), (authority, folder.authority)):
        if not each.not_valid_before_utc <= at <= each.not_valid_after_utc:
            raise KeysExpiredError(file, each.not_valid_before_utc, each.not_valid_after_utc, at)
    if read_key(folder.key).public_key() != certificate.public_key():
        raise KeysUnreadableError(folder.key, "got the key of another certificate, allowed that of the one beside it")
    return Credentials(identity=identity, folder=folder, ends=certificate.not_valid_after_utc)


def identity_of(certificate: x509.Certificate, path: Path) -> Identity:
    """Return the holder that a certificate names.

    Raises:
        KeysUnreadableError: Its common name is missing, doubled or none of ours.
    """
    names = [str(name.value) for name in certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)]
    if len(names) != 1:
        raise KeysUnreadableError(path, f"got a certificate with {len(names)} common names, allowed one")
    try:
        return Identity.of(names[0])
    except (IdentityError, RobotNameError) as error:
        raise KeysUnreadableError(path, f"got common name {names[0]!r}, allowed one of ours: {error}") from error


def _holder_folder(path: Path, wanted: Identity) -> KeyFolder:
    """Return the folder of the keys themselves, given it or the deployment's."""
    if not path.is_dir():
        raise KeysMissingError(path)
    own = KeyFolder(path=path)
    return own if own.certificate.exists() else KeyFolder(path=path / wanted.common_name)
