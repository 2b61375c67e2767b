"""Errors of the bridge; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import PassafeError


class BridgePortError(PassafeError):
    """An address that the bridge cannot listen on.

    Attributes:
        host: The address.
        port: The TCP port.
    """

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host = host
        self.port = port
        super().__init__(f"bridge at {host}:{port}: cannot listen: {reason}; choose another with --host and --port")
