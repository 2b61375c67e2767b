"""Errors of keys; the tree of all errors is in ``passafe.errors``."""

from datetime import datetime
from pathlib import Path
from typing import ClassVar

from passafe.errors import NotAllowedError, PassafeError


class KeysError(PassafeError):
    """Keys that cannot be used.

    Attributes:
        path: The file or folder.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        super().__init__(f"keys {path}: {text}")


class KeysMissingError(KeysError):
    """A file of keys that is not there."""

    def __init__(self, path: Path, remedy: str = "make keys with `passafe keys make`") -> None:
        super().__init__(path, f"got no such file or folder, allowed one of a deployment: {remedy}")


class KeysUnreadableError(KeysError):
    """A file that cannot be read or is no such file, or one that others can read.

    Attributes:
        reason: Why.
    """

    def __init__(self, path: Path, reason: str) -> None:
        self.reason = reason
        super().__init__(path, reason)


class KeysExpiredError(KeysError):
    """A certificate before or after its time.

    Attributes:
        begins: When it begins to be valid.
        ends: When it ceases to be.
    """

    def __init__(self, path: Path, begins: datetime, ends: datetime, now: datetime) -> None:
        self.begins = begins
        self.ends = ends
        super().__init__(
            path,
            f"got a certificate for {begins:%Y-%m-%d %H:%M} to {ends:%Y-%m-%d %H:%M} UTC, allowed one for now, "
            f"{now:%Y-%m-%d %H:%M}: renew it with `passafe keys renew`, or set the clock",
        )


class ForeignKeysError(KeysError):
    """A certificate of another authority."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "got a certificate of another authority, allowed one that the ca.pem beside it signed")


class KeysExistError(KeysError):
    """A deployment that would be overwritten."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, "got an existing authority, allowed an empty folder: `passafe keys add` extends one")


class KeysMismatchError(NotAllowedError):
    """A certificate of another robot or role than the process that is to use it."""

    quotes_got: ClassVar[bool] = True

    def __init__(self, path: Path, got: str, allowed: str) -> None:
        self.path = path
        self.prefix = f"keys {path}: "
        super().__init__("certificate", got, allowed)


class NotAdmittedError(PassafeError):
    """A certificate that the router does not list, so that it drops what its holder sends, or another topic table.

    Attributes:
        common_name: The certificate's holder.
        locator: Where the router listens.
    """

    def __init__(self, common_name: str, locator: str, reason: str) -> None:
        self.common_name = common_name
        self.locator = locator
        super().__init__(f"{locator}: the router does not admit {common_name!r}: {reason}")
