"""Errors of running systems; the tree of all errors is in ``passafe.errors``."""

from collections.abc import Sequence
from typing import ClassVar

from passafe.errors import NotAllowedError, PassafeError
from passafe_services.suggestion import suggestion


class EndpointError(NotAllowedError):
    """A host or port that can be no endpoint."""

    quotes_got: ClassVar[bool] = True


class BusError(PassafeError):
    """The router cannot be reached, or cannot listen.

    Attributes:
        locator: Where.
        reason: Why.
    """

    def __init__(self, locator: str, reason: str) -> None:
        self.locator = locator
        self.reason = reason
        super().__init__(f"{locator}: {reason}")


class OpenRouterError(PassafeError):
    """A router that speaks TLS but lets everybody do everything.

    Attributes:
        locator: Where it listens.
    """

    def __init__(self, locator: str) -> None:
        self.locator = locator
        super().__init__(f"{locator}: the router answers what no access control would let in: it is none of passafe's")


class PortInUseError(PassafeError):
    """The router's port is taken, most likely by another running system.

    Attributes:
        host: Address that the router was to listen on.
        port: The port.
    """

    def __init__(self, host: str, port: int) -> None:
        self.host = host
        self.port = port
        super().__init__(f"port {port} on {host} is in use: is another router running? Choose another port.")


class PublisherError(NotAllowedError):
    """A process that may not publish a topic."""

    quotes_got: ClassVar[bool] = True

    def __init__(self, source: str, topic: str, allowed: Sequence[str]) -> None:
        super().__init__(f"publisher of {topic}", source, ", ".join(allowed))


class RoleError(NotAllowedError):
    """A process that publishes in the name of another, which the router would drop without a word."""

    quotes_got: ClassVar[bool] = True

    def __init__(self, topic: str, common_name: str, source: str) -> None:
        super().__init__(f"keys to publish {topic} as {source}", common_name, f"those of a {source}")


class LinkNameError(NotAllowedError):
    """Settings for a link that does not exist."""

    quotes_got: ClassVar[bool] = True

    def __init__(self, got: str, allowed: Sequence[str]) -> None:
        super().__init__("link", got, ", ".join(allowed) + suggestion(got, allowed))


class LinkSilentError(PassafeError):
    """Nothing was received of a link, or no answer came.

    Attributes:
        link: Its name.
        reader: Process at whose inlet it sits.
        waited_s: For how long.
    """

    def __init__(self, link: str, reader: str, waited_s: float) -> None:
        self.link = link
        self.reader = reader
        self.waited_s = waited_s
        super().__init__(f"link {link}: no answer from {reader} within {waited_s:g} s: is it running?")


class LinkRefusedError(PassafeError):
    """The process that reads a link refused what it was asked for; the settings before are still in force.

    Attributes:
        link: Its name.
        reason: Why, in words.
    """

    def __init__(self, link: str, reason: str) -> None:
        self.link = link
        self.reason = reason
        super().__init__(f"{link} refused: {reason}")


class PlantSilentError(PassafeError):
    """No plant acknowledged a press of the emergency stop, or its clear.

    Attributes:
        waited_s: For how long.
    """

    def __init__(self, waited_s: float) -> None:
        self.waited_s = waited_s
        super().__init__(f"emergency stop: no answer from plant within {waited_s:g} s: is it running?")


class StopPressedAgainError(PassafeError):
    """The emergency stop was pressed again while it was being cleared.

    Attributes:
        source: Process that pressed it.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        super().__init__(f"emergency stop: still latched, {source} pressed it again: ask there, then clear again")
