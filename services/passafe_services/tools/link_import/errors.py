"""Errors of imported measurements; the tree of all errors is in ``passafe.errors``."""

from pathlib import Path

from passafe.errors import NotAllowedError


class MeasurementError(NotAllowedError):
    """A file that is no usable measurement of a network.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path, where: str, got: object, allowed: str) -> None:
        self.path = path
        super().__init__(f"{path}{where}", got, allowed)
