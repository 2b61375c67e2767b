"""Errors of the runtime.

* ``RuntimeFault``
    * ``EndpointError``: a host or port that can be no endpoint
    * ``BusError``: the router cannot be reached, or cannot listen
    * ``PortInUseError``: the router's port is taken
    * ``PublisherError``: a process that may not publish a topic
    * ``LinkNameError``: settings for a link that does not exist
    * ``LinkSilentError``: nothing was heard of a link
    * ``LinkRefusedError``: the process that reads a link refused what it was asked for
"""

from collections.abc import Sequence

from passafe_services.suggestion import suggestion


class RuntimeFault(Exception):  # noqa: N818  "RuntimeError" is taken, and means something else
    """Anything that keeps a process of a running system from starting or going on."""


class EndpointError(RuntimeFault):
    """A host or port that can be no endpoint.

    Attributes:
        field: Name of the field.
        got: Its value.
        allowed: What is allowed, in words.
    """

    def __init__(self, field: str, got: object, allowed: str) -> None:
        self.field = field
        self.got = got
        self.allowed = allowed
        super().__init__(f"{field}: got {got!r}, allowed {allowed}")


class BusError(RuntimeFault):
    """The router cannot be reached, or cannot listen.

    Attributes:
        locator: Where.
        reason: Why.
    """

    def __init__(self, locator: str, reason: str) -> None:
        self.locator = locator
        self.reason = reason
        super().__init__(f"{locator}: {reason}")


class PortInUseError(RuntimeFault):
    """The router's port is taken, most likely by another running system.

    Attributes:
        host: Address that the router was to listen on.
        port: The port.
    """

    def __init__(self, host: str, port: int) -> None:
        self.host = host
        self.port = port
        super().__init__(f"port {port} on {host} is in use: is another router running? Choose another port.")


class PublisherError(RuntimeFault):
    """A process that may not publish a topic.

    Attributes:
        source: Name of the process.
        topic: Name of the topic.
        allowed: Processes that may publish it.
    """

    def __init__(self, source: str, topic: str, allowed: Sequence[str]) -> None:
        self.source = source
        self.topic = topic
        self.allowed = tuple(allowed)
        super().__init__(f"publisher of {topic}: got {source!r}, allowed {', '.join(allowed)}")


class LinkNameError(RuntimeFault):
    """Settings for a link that does not exist.

    Attributes:
        got: The name.
        allowed: Names of the links there are.
    """

    def __init__(self, got: str, allowed: Sequence[str]) -> None:
        self.got = got
        self.allowed = tuple(allowed)
        super().__init__(f"link: got {got!r}, allowed {', '.join(allowed)}{suggestion(got, allowed)}")


class LinkSilentError(RuntimeFault):
    """Nothing was heard of a link, or no answer came.

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


class LinkRefusedError(RuntimeFault):
    """The process that reads a link refused what it was asked for; the settings before are still in force.

    Attributes:
        link: Its name.
        reason: Why, in words.
    """

    def __init__(self, link: str, reason: str) -> None:
        self.link = link
        self.reason = reason
        super().__init__(f"{link} refused: {reason}")
