"""Address of the router."""

from dataclasses import dataclass
from typing import Final, Self

from passafe_protocol.keys import DEFAULT_ROBOT

from passafe_services.keys.credentials import Credentials, load_credentials
from passafe_services.keys.throw_away import throw_away_folder
from passafe_services.loop.errors import EndpointError

LOOPBACK: Final = "127.0.0.1"
DEFAULT_PORT: Final = 7447
_LARGEST_PORT: Final = 65_535


@dataclass(frozen=True, kw_only=True, slots=True)
class RouterEndpoint:
    """Endpoint on which the router listens and to which its clients connect, over TCP.

    Attributes:
        host: Host name or address; IPv6 addresses without brackets.
        port: TCP port, from 1 to 65535.
        credentials: Keys of the process that listens or connects; ``None``: no TLS, everybody may do everything.

    Raises:
        EndpointError: Host or port is not valid.
    """

    host: str = LOOPBACK
    port: int = DEFAULT_PORT
    credentials: Credentials | None = None

    def __post_init__(self) -> None:
        if not self.host or any(character.isspace() or character in "/[]#?" for character in self.host):
            raise EndpointError("host", self.host, "a host name or address")
        if not 1 <= self.port <= _LARGEST_PORT:
            raise EndpointError("port", self.port, f"1 to {_LARGEST_PORT}")

    @classmethod
    def of_demo(cls, port: int, role: str, robot: str = DEFAULT_ROBOT) -> Self:
        """Return the endpoint of a demo that this user runs on this host, with its keys for a role.

        Raises:
            KeysMissingError: There is no such demo, or it runs without keys.
        """
        return cls(port=port, credentials=load_credentials(throw_away_folder(port), role, robot))

    @property
    def locator(self) -> str:
        """Zenoh locator such as ``tls/127.0.0.1:7447``."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"{'tls' if self.credentials else 'tcp'}/{host}:{self.port}"
