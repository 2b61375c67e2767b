"""Errors of the dashboard; the tree of all errors is in ``passafe.errors``."""

from passafe.errors import NotAllowedError, PassafeError


class PageAddressError(NotAllowedError):
    """The page's address cannot be listened on.

    Attributes:
        host: Address that was to be listened on.
        port: Port that was to be listened on.
    """

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host = host
        self.port = port
        allowed = "an address of this machine and a port that this user may listen on"
        super().__init__("dashboard address", f"{host}:{port} ({reason})", allowed)


class PagePortInUseError(PageAddressError):
    """Another program listens on the page's port."""

    def __init__(self, host: str, port: int) -> None:
        super().__init__(host, port, "in use")
        advice = "is another demo running? Stop it, or choose another port; 0 takes a free one."
        self.args = (f"dashboard port {port} on {host} is in use: {advice}",)


class PageAccessError(NotAllowedError):
    """Options of the page's access that do not go together, or a file that is none."""


class SeriesError(NotAllowedError):
    """A series for the report that does not fit together."""

    prefix = "series "


class LinkUpdateError(NotAllowedError):
    """Settings of a link that do not go together.

    Attributes:
        loc: Where in the settings.
    """

    def __init__(self, loc: tuple[int | str, ...], got: object, allowed: str) -> None:
        self.loc = loc
        super().__init__("link", got, allowed)


class LinkAnswerError(PassafeError):
    """Nothing was received of a link.

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


class NothingToStopError(PassafeError):
    """The emergency stop was pressed while no run is going on."""

    def __init__(self) -> None:
        super().__init__("No run is going on: there is nothing to stop.")


class StopNameError(NotAllowedError):
    """A clear that names another emergency stop than the one that is latched."""

    def __init__(self, got: int, latched: int) -> None:
        super().__init__("emergency stop to clear", got, str(latched) if latched else "none: no stop is latched")


class StopAnswerError(PassafeError):
    """No plant acknowledged a press of the emergency stop, or its clear.

    Attributes:
        waited_s: For how long.
    """

    def __init__(self, waited_s: float) -> None:
        self.waited_s = waited_s
        super().__init__(f"emergency stop: no answer from plant within {waited_s:g} s: is it running?")


class NoSessionError(PassafeError):
    """Nobody supervises runs here: each process of this system was started by itself."""

    def __init__(self) -> None:
        super().__init__("runs are started, ended and changed on the page of `passafe demo` alone")


class SessionRefusedError(PassafeError):
    """A request that the supervisor of the demo refused.

    Attributes:
        field: What of the request cannot be used; empty if the request is not possible now.
    """

    def __init__(self, field: str, reason: str) -> None:
        self.field = field
        super().__init__(reason)


class SessionAnswerError(PassafeError):
    """The supervisor of the demo did not answer.

    Attributes:
        waited_s: For how long.
    """

    def __init__(self, waited_s: float) -> None:
        self.waited_s = waited_s
        super().__init__(f"no answer from the demo's supervisor within {waited_s:g} s")


class ArchiveNameError(NotAllowedError):
    """A name that is not that of a log or experiment in the runs folder."""

    def __init__(self, what: str, got: str, allowed: str) -> None:
        super().__init__(what, ascii(got), allowed)


class TooManyJobsError(PassafeError):
    """More work than the page accepts at a time.

    Attributes:
        waiting: Jobs that are already waiting or running.
    """

    def __init__(self, waiting: int) -> None:
        self.waiting = waiting
        super().__init__(f"jobs: {waiting} are waiting or running already; cancel one, or wait")


class OneSweepError(TooManyJobsError):
    """An experiment was started while another one runs."""

    def __init__(self, running: str) -> None:
        super().__init__(1)
        self.args = (f"experiment {running} is running, and one runs at a time: stop it, or wait",)


class SweepSizeError(NotAllowedError):
    """An experiment that is too large for the page."""

    def __init__(self, name: str, got: str, allowed: str) -> None:
        super().__init__(f"experiment {name}", got, f"{allowed} in the page: ask for fewer, or use passafe experiment")


class SweptAlreadyError(NotAllowedError):
    """A folder in which another process writes results."""

    def __init__(self, name: str, pid: int) -> None:
        super().__init__(f"experiment {name}", f"one that process {pid} is running", "one that nothing runs")


class JobNameError(NotAllowedError):
    """A job that there is not, or no more."""

    def __init__(self, got: str) -> None:
        super().__init__("job", ascii(got), "the id of a job of this server; old ones are forgotten")


class TooLargeLogError(NotAllowedError):
    """A log that is too large for what keeps it in memory."""

    def __init__(self, name: str, size_bytes: int, most_bytes: int, command: str) -> None:
        got = f"{size_bytes / 1e6:.0f} MB"
        super().__init__(f"log {name}", got, f"up to {most_bytes / 1e6:.0f} MB in the page: use {command}")
