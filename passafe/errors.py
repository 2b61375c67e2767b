"""Errors of passafe, of the core and of all packages around it. The text of each is one message to the user.

* ``PassafeError``: anything that passafe refuses, or cannot do for a reason outside of it
    * ``NotAllowedError``: something that may not be what it is: field, got, allowed
        * ``DesignError``: a part of a design that cannot be used as given
            * ``ShapeError``: an expression or vector of the wrong shape
            * ``RelativeDegreeError``: a barrier that the input never reaches
        * ``ConfigurationError``: a file of configuration with fields that hold what they may not
            * ``ScenarioError``: a scenario
                * ``UnknownScenarioError``: no scenario of that name and no such file
                * ``UnreadableScenarioError``: a file that is no TOML
                * ``LinkTraceError``: a file that is no trace of packet-delivery times
            * ``ContractError``: a contract of a log
            * ``ExperimentError``: an experiment
                * ``UnknownExperimentError``: no experiment of that name and no such file
                * ``UnreadableExperimentError``: a file that is no TOML
        * ``ColumnNameError``: a column that a table does not have
        * ``TopicNameError``: a topic that no log has
        * ``MeasurementError``: a file that is no measurement of a network
        * ``OptionError``: an option of a command
        * ``ChangeError``: a change that cannot be made to a run
        * ``AlignmentError``: runs that cannot be aligned as asked
        * ``UnusableScenarioError``: a scenario that a check refuses
        * ``SourceConfigError``: a setting of a source of commands
        * ``RecordingError``: a place in a recorded command series
        * ``DriverError``: a driver that cannot read or move its robot
        * ``TerminalError``: no terminal that a person could drive from
        * ``EndpointError``: a host or port that can be no endpoint
        * ``PublisherError``: a process that may not publish a topic
        * ``RoleError``: a process that publishes in the name of another
        * ``KeysMismatchError``: a certificate of another robot or role
        * ``LinkNameError``: settings for a link that does not exist
        * ``LinkUpdateError``: settings of a link that do not go together
        * ``StopNameError``: a clear of another emergency stop than the one that is latched
        * ``RobotCodeError``: a function that returns no robot, or a file without it
        * ``IdentifyError``: logs from which nothing can be estimated
        * ``PageAddressError``: an address that the page cannot listen on
            * ``PagePortInUseError``: another program listens on its port
        * ``ArchiveNameError``: a log or experiment that the folder of a page does not hold
        * ``JobNameError``: a job that the page does not know
        * ``SweepSizeError``: an experiment that is too large for the page
        * ``SweptAlreadyError``: a folder in which another process writes results
        * ``TooLargeLogError``: a log that is too large for what keeps it in memory
        * ``PageAccessError``: options of access to the page that do not go together
        * ``SeriesError``: a series for the report that does not fit together
        * ``FeasibilityError``: a map that cannot be made
        * ``NoSafeStartError``: a box of starts without a safe one
        * ``ResultsFileError``: a file of results that a sweep cannot resume from
        * ``SchedulerError``: a cluster that cannot be used
        * ``LiveRunError``: a live run without a log
    * ``MissingPackageError``: a package of an extra that is not installed
    * ``IntegrationError``: a step of a nonlinear plant that did not reach its stated accuracy
    * ``ProtocolError``: anything wrong with what crosses the wire
        * ``DecodeError``: bytes that are no message of their topic
            * ``ChecksumError``: bytes that are not those that were sent
        * ``SchemaVersionError``: a message of another version of ``passafe.proto``; also a ``NotAllowedError``
        * ``InvalidMessageError``: a field that may not hold what it holds; also a ``NotAllowedError``
            * ``SessionError``: a message of a session, or of a number, that its sender cannot have come to
        * ``RobotNameError``: a name that no robot can have; also a ``NotAllowedError``
        * ``IdentityError``: a role or name that no process can have; also a ``NotAllowedError``
        * ``LinkSettingsError``: a link's setting outside its range; also a ``NotAllowedError``
    * ``LogFileError``: a log that cannot be used
        * ``LogWriteError``: it cannot be created or grown
        * ``LogReadError``: it is missing, empty or no MCAP file
        * ``ForeignLogError``: it is not of a run of passafe
        * ``ReviewError``: it can be read, but not reviewed
            * ``ScenarioRecordError``: this build cannot read its scenario
            * ``MismatchedLogError``: its messages do not fit its scenario
            * ``RerunError``: its run cannot be repeated
    * ``ExportError``: output of an export that cannot be written
    * ``UnusualLayoutError``: a message that no others are laid out like
    * ``DecodingWorkerLostError``: a process that decoded part of a log was killed
    * ``KeysError``: keys that cannot be used
        * ``KeysMissingError``: a file of keys that is not there
        * ``KeysUnreadableError``: a file that cannot be read or is no such file, or one that others can read
        * ``KeysExpiredError``: a certificate before or after its time
        * ``ForeignKeysError``: a certificate of another authority
        * ``KeysExistError``: a deployment that would be overwritten
    * ``NotAdmittedError``: a certificate that the router does not list
    * ``BusError``: the router cannot be reached, or cannot listen
    * ``OpenRouterError``: a router without access control
    * ``BridgePortError``: an address that the bridge cannot listen on
    * ``PortInUseError``: the router's port is taken
    * ``LinkSilentError``: nothing was received of a link
    * ``LinkRefusedError``: the process that reads a link refused its settings
    * ``LinkAnswerError``: nothing was received of a link that the page was to change
    * ``PlantSilentError``: no plant acknowledged a press of the emergency stop, or its clear
    * ``StopPressedAgainError``: the emergency stop was pressed again while it was being cleared
    * ``TooManyJobsError``: more work than the page accepts at a time
        * ``OneSweepError``: a sweep while another one runs
    * ``StopAnswerError``: no plant acknowledged a press or a clear that the page asked for
    * ``NothingToStopError``: the emergency stop was pressed while no run is going on
    * ``NoSessionError``: runs that no demo supervises
    * ``SessionRefusedError``: a request that the supervisor of a demo refused
    * ``SessionAnswerError``: a supervisor of a demo that does not answer
    * ``WorkerLostError``: a worker process is gone
"""

from reprlib import Repr
from typing import Any, ClassVar, Self

_SHORT = Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 100


class PassafeError(Exception):
    """Anything that passafe refuses, or cannot do for a reason outside of it."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Return what pickle restores the error from, whatever its constructor takes: workers send their errors."""
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[PassafeError], args: tuple[object, ...]) -> PassafeError:
    return kind.__new__(kind, *args)


class NotAllowedError(PassafeError):
    """Something that may not be what it is; the text is ``<prefix><field>: got …, allowed …``.

    Attributes:
        field: What it is, for example ``barrier 'disk' class_k``.
        got: What was given.
        allowed: What is allowed, in words.
        prefix: Stands before the field in the text.
        quotes_got: Whether ``got`` is a value, which the text shows as Python writes it and shortened; else it is
            a number or words.
    """

    prefix: str = ""
    quotes_got: ClassVar[bool] = False

    def __init__(self, field: str, got: object, allowed: str) -> None:
        self.field = field
        self.got = got
        self.allowed = allowed
        shown = _SHORT.repr(got) if self.quotes_got else got
        super().__init__(f"{self.prefix}{field}: got {shown}, allowed {allowed}")


class DesignError(NotAllowedError):
    """A part of a design that cannot be used as given."""


class ShapeError(DesignError):
    """An expression or vector of the wrong shape."""


class RelativeDegreeError(DesignError):
    """A barrier whose derivatives never contain the input, or never so that it has an effect.

    Attributes:
        barrier: Name of the barrier.
        tried: Number of derivatives that were taken.
        is_contained: Whether the input stands in one of them, without an effect at any state that was tried.
    """

    def __init__(self, barrier: str, tried: int, *, is_contained: bool = False) -> None:
        self.barrier = barrier
        self.tried = tried
        self.is_contained = is_contained
        contain = (
            "contain the input, but it has no effect at any state tried" if is_contained else "do not contain the input"
        )
        remedy = ", and h must not be flat nearly everywhere: take what it is a function of" if is_contained else ""
        super().__init__(
            f"barrier {barrier!r}",
            f"an h whose first {tried} time derivatives {contain}",
            f"an h with a relative degree: the input must reach it through the dynamics{remedy}",
        )


class MissingPackageError(PassafeError):
    """A package that is not installed, because it comes with an extra of passafe.

    Attributes:
        package: The package.
        extra: The extra.
    """

    def __init__(self, package: str, extra: str) -> None:
        self.package = package
        self.extra = extra
        super().__init__(f"no package {package!r}: install it with pip install 'passafe[{extra}]'")

    @classmethod
    def of(cls, error: ModuleNotFoundError, extra: str) -> Self:
        """Return the error for a failed import; raise that itself if the module is one of passafe."""
        package = str(error.name).partition(".")[0]
        if package.startswith("passafe"):
            raise error
        return cls(package, extra)


class IntegrationError(PassafeError):
    """A step of a nonlinear plant that did not reach its stated accuracy.

    Attributes:
        error: Estimated local error that remained.
        tolerance: Stated accuracy.
        substeps: Number of substeps at which the attempt ended.
    """

    def __init__(self, error: float, tolerance: float, substeps: int) -> None:
        self.error = error
        self.tolerance = tolerance
        self.substeps = substeps
        super().__init__(f"integration error: got {error:.3g} with {substeps} substeps, allowed {tolerance:.3g}")
