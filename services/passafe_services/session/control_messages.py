"""Messages between a demo's supervisor and its page: requests, answers, and the state of the session."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from passafe_services.loop.process_name import ProcessName


class ControlMessage(BaseModel):
    """Base of every message: immutable, finite numbers only, unknown keys refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class RunChoices(ControlMessage):
    """Choices of a run; of what is null, the demo's command line decides, and else the scenario.

    Attributes:
        scenario: Name of a scenario: a shipped one, or the one that the demo was started with.
        mode: What the filter enforces.
        prediction: Whether the filter decides for the state at which its input will take effect.
        gatekeeper: Whether an input is sent only if the fail-safe is proven to keep every barrier after it.
        rate_hz: Ticks per second.
        recording: Whether the run has a log.
    """

    scenario: str
    mode: Literal["off", "safe", "passive", "both"] | None = None
    prediction: bool | None = None
    gatekeeper: bool | None = None
    rate_hz: Annotated[float, Field(ge=10, le=2000)] | None = None
    recording: bool = True


class StartRun(ControlMessage):
    """Request for a run, in the place of the present one.

    Attributes:
        choices: What it is to be.
        start_stopped: Whether its plant starts with the emergency stop latched, as that of the present one has it.
    """

    type: Literal["start"] = "start"
    choices: RunChoices
    start_stopped: bool = False


class EndRun(ControlMessage):
    """Request for the end of the present run."""

    type: Literal["end"] = "end"


class KillProcess(ControlMessage):
    """Request to kill a process."""

    type: Literal["kill"] = "kill"
    process: ProcessName


class RestartProcess(ControlMessage):
    """Request to stop a process, if it still runs, and to start it again.

    Attributes:
        process: The process.
        start_stopped: Plant: whether it starts with the emergency stop latched, as before.
    """

    type: Literal["restart"] = "restart"
    process: ProcessName
    start_stopped: bool = False


PageRequest = StartRun | EndRun | KillProcess | RestartProcess
"""What a page may ask for."""


class NumberedRequest(ControlMessage):
    """A request with the number that its answer names."""

    number: int
    request: Annotated[PageRequest, Field(discriminator="type")]


class Refusal(ControlMessage):
    """Reason for which a request was refused.

    Attributes:
        field: What of the request cannot be used; empty if the request is not possible now.
        reason: In words.
    """

    field: str = ""
    reason: str


class RequestAnswer(ControlMessage):
    """Answer to a request: accepted, unless it holds a refusal."""

    type: Literal["answer"] = "answer"
    number: int
    run: int
    refusal: Refusal | None = None


class EndedRun(ControlMessage):
    """The run before.

    Attributes:
        run: Its number.
        log: Name of its log; ``None``: it was not recorded.
        detail: Why it ended.
        outcome: Verdict in a word; empty while the log is being reviewed, and without one.
        words: Verdict in words.
    """

    run: int
    log: str | None
    detail: str
    outcome: str = ""
    words: str = ""


class ProcessView(ControlMessage):
    """One process of the session.

    Attributes:
        state: starting, running, restarting or down.
        can: What may be requested of it: kill, restart.
    """

    state: str
    can: tuple[str, ...]


class SessionState(ControlMessage):
    """State of a session, as the page shows it.

    Attributes:
        state: Of its present run.
        run: Number of the present run, or of the last one; the first has 1.
        scenario: Its scenario, as a request would name it.
        mode: What its filter enforces.
        prediction: Whether its filter predicts.
        gatekeeper: Whether its filter has a gatekeeper.
        rate_hz: Its ticks per second.
        recording: Whether it has a log.
        log: Name of its log.
        can: What may be requested.
        scenarios: Scenarios that may be requested.
        processes: The processes by name.
        last: The run before.
        trouble: Why the last change did not come about; empty if it did.
    """

    type: Literal["state"] = "state"
    state: Literal["starting", "running", "stopping", "stopped"]
    run: int
    scenario: str
    mode: str
    prediction: bool
    gatekeeper: bool
    rate_hz: float
    recording: bool
    log: str | None
    can: tuple[str, ...]
    scenarios: tuple[str, ...]
    processes: dict[str, ProcessView]
    last: EndedRun | None
    trouble: str

    def json_dict(self) -> dict[str, Any]:
        """Return the state as the page receives it."""
        return self.model_dump(mode="json", exclude={"type"})


FromSupervisor = Annotated[RequestAnswer | SessionState, Field(discriminator="type")]
FROM_SUPERVISOR: TypeAdapter[RequestAnswer | SessionState] = TypeAdapter(FromSupervisor)
FROM_PAGE: TypeAdapter[NumberedRequest] = TypeAdapter(NumberedRequest)
