"""Folder of a deployment: its authority, and a folder of keys for each holder."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Final, Self

from passafe_protocol.identity import ROLES, ROUTER, Identity

from passafe_services.keys.authority import AUTHORITY_DAYS, CERTIFICATE_DAYS, Authority, KeyPair
from passafe_services.keys.credentials import identity_of
from passafe_services.keys.errors import KeysExistError, KeysMissingError
from passafe_services.keys.key_files import (
    CERTIFICATE_MODE,
    FOLDER_MODE,
    KEY_MODE,
    KeyFolder,
    read_certificate,
    read_key,
    write_file,
)

AUTHORITY_FOLDER: Final = "authority"
"""Subfolder with the authority's private key: the only one that no host of the running system needs."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Holder:
    """Holder of a certificate in a deployment.

    Attributes:
        identity: Who it is.
        ends: When the certificate ceases to be valid.
    """

    identity: Identity
    ends: datetime


class Deployment:
    """Certificates of the robots, routers and operators of one deployment.

    Args:
        path: Its folder.
        authority: Its authority.
    """

    def __init__(self, path: Path, authority: Authority) -> None:
        self.path = path
        self._authority = authority

    @classmethod
    def create(cls, path: Path, *, authority_days: float = AUTHORITY_DAYS) -> Self:
        """Make the folder with a new authority and no holder.

        Raises:
            KeysExistError: The folder has an authority already.
        """
        folder = path / AUTHORITY_FOLDER
        if folder.exists():
            raise KeysExistError(path)
        path.mkdir(mode=FOLDER_MODE, parents=True, exist_ok=True)
        folder.mkdir(mode=FOLDER_MODE)
        authority = Authority.create(authority_days)
        write_file(folder / "ca.pem", authority.pair.certificate, CERTIFICATE_MODE)
        write_file(folder / "ca.key.pem", authority.pair.key, KEY_MODE)
        return cls(path, authority)

    @classmethod
    def open(cls, path: Path) -> Self:
        """Open the folder of a deployment.

        Raises:
            KeysMissingError: It has no authority.
            KeysUnreadableError: The authority's files cannot be used.
        """
        folder = path / AUTHORITY_FOLDER
        if not folder.is_dir():
            raise KeysMissingError(folder)
        return cls(path, Authority(read_certificate(folder / "ca.pem"), read_key(folder / "ca.key.pem")))

    def holders(self) -> list[Holder]:
        """Return the holders, sorted by role, robot and name.

        Raises:
            KeysUnreadableError: A certificate cannot be read.
        """
        found = []
        for file in self.path.glob("*/certificate.pem"):
            certificate = read_certificate(file)
            found.append(Holder(identity=identity_of(certificate, file), ends=certificate.not_valid_after_utc))
        return sorted(found, key=lambda holder: holder.identity)

    def issue(
        self, identities: Iterable[Identity], *, hosts: Sequence[str] = (), days: float = CERTIFICATE_DAYS
    ) -> list[Identity]:
        """Issue certificates, also in place of earlier ones; return their holders.

        Args:
            identities: The holders.
            hosts: Routers: further names and addresses by which they are reached.
            days: How long the certificates are valid.
        """
        issued = list(identities)
        for identity in issued:
            pair = self._authority.issue(identity, hosts=hosts, days=days)
            self._folder(identity).write(pair, self._authority_certificate())
        self._list_admitted()
        return issued

    def remove(self, identity: Identity) -> None:
        """Delete the keys of a holder; routers that get the new list and restart admit it no more.

        Raises:
            KeysMissingError: It has none.
        """
        folder = self._folder(identity)
        if not folder.certificate.exists():
            raise KeysMissingError(folder.path, f"there is no {identity.common_name}")
        for file in sorted(folder.path.iterdir()):
            file.unlink()
        folder.path.rmdir()
        self._list_admitted()

    def _folder(self, identity: Identity) -> KeyFolder:
        return KeyFolder(path=self.path / identity.common_name)

    def _authority_certificate(self) -> bytes:
        pair: KeyPair = self._authority.pair
        return pair.certificate

    def _list_admitted(self) -> None:
        everyone = [holder.identity for holder in self.holders()]
        for router in (identity for identity in everyone if identity.role == ROUTER):
            self._folder(router).write_admitted(everyone)


def identities_of(
    robots: Sequence[str], operators: Sequence[str] = (), routers: Sequence[str] = ("",)
) -> list[Identity]:
    """Return the identities that robots need: a router, every role of each robot, and each named operator of each.

    Args:
        robots: Names of the robots.
        operators: Names of persons who may drive, each with a certificate of its own.
        routers: Names of the routers; an empty one for the only router.
    """
    found = [Identity(role=ROUTER, name=name) for name in routers]
    for robot in robots:
        found += [Identity(role=role, robot=robot) for role in ROLES]
        found += [Identity(role="operator", robot=robot, name=name) for name in operators]
    return found
