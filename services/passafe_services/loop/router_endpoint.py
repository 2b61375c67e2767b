"""Address of the router."""

from dataclasses import dataclass
from typing import Final

from passafe_services.loop.errors import EndpointError

LOOPBACK: Final = "127.0.0.1"
DEFAULT_PORT: Final = 7447
_LARGEST_PORT: Final = 65_535


@dataclass(frozen=True, kw_only=True, slots=True)
class RouterEndpoint:
    """TCP endpoint on which the router listens and to which its clients connect.

    Attributes:
        host: Host name or address; IPv6 addresses without brackets.
        port: TCP port, from 1 to 65535.

    Raises:
        EndpointError: Host or port is not valid.
    """

    host: str = LOOPBACK
    port: int = DEFAULT_PORT

    def __post_init__(self) -> None:
        if not self.host or any(character.isspace() or character in "/[]#?" for character in self.host):
            raise EndpointError("host", self.host, "a host name or address")
        if not 1 <= self.port <= _LARGEST_PORT:
            raise EndpointError("port", self.port, f"1 to {_LARGEST_PORT}")

    @property
    def locator(self) -> str:
        """Zenoh locator such as ``tcp/127.0.0.1:7447``."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"tcp/{host}:{self.port}"
