"""Errors of the dashboard.

* ``DashboardError``
    * ``PageAddressError``: the page's address cannot be listened on
        * ``PagePortInUseError``: another program listens on its port
    * ``SeriesError``: a series for the report that does not fit together
    * ``LinkUpdateError``: settings of a link that do not go together
    * ``LinkAnswerError``: nothing was heard of a link
"""


class DashboardError(Exception):
    """Anything that the dashboard refuses."""


class PageAddressError(DashboardError):
    """The page's address cannot be listened on.

    Attributes:
        host: Address that was to be listened on.
        port: Port that was to be listened on.
        reason: What is wrong with it.
    """

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host = host
        self.port = port
        self.reason = reason
        super().__init__(
            f"dashboard address: got {host}:{port} ({reason}), allowed an address of this machine and a port "
            "that this user may listen on"
        )


class PagePortInUseError(PageAddressError):
    """Another program listens on the page's port."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(host, port, "in use")
        advice = "is another demo running? Stop it, or choose another port; 0 takes a free one."
        self.args = (f"dashboard port {port} on {host} is in use: {advice}",)


class SeriesError(DashboardError):
    """A series for the report that does not fit together.

    Attributes:
        field: Name of the field.
        got: Its shape or value.
        allowed: What is allowed, in words.
    """

    def __init__(self, field: str, got: object, allowed: str) -> None:
        self.field = field
        self.got = got
        self.allowed = allowed
        super().__init__(f"series {field}: got {got}, allowed {allowed}")


class LinkUpdateError(DashboardError):
    """Settings of a link that do not go together.

    Attributes:
        loc: Where in the settings.
        got: What was asked for.
        allowed: What is allowed, in words.
    """

    def __init__(self, loc: tuple[int | str, ...], got: object, allowed: str) -> None:
        self.loc = loc
        self.got = got
        self.allowed = allowed
        super().__init__(f"link: got {got}, allowed {allowed}")


class LinkAnswerError(DashboardError):
    """Nothing was heard of a link.

    Attributes:
        link: Its name.
        reader: Process at whose inlet it sits.
        reason: In words.
    """

    def __init__(self, link: str, reader: str, reason: str) -> None:
        self.link = link
        self.reader = reader
        self.reason = reason
        super().__init__(f"link {link}: {reason}: is {reader} running?")
