"""Messages as Python values: one immutable record for each message of ``passafe.proto``.

Nodes exchange these records, never protobuf, so that a closed loop in one process needs no encoding. Field names, units
and meanings are those of ``passafe.proto``; the header is kept beside the body.
"""

from enum import IntEnum, StrEnum
from typing import Final, TypeAlias

from msgspec import Struct

SCHEMA_VERSION: Final = 3
"""Version of ``passafe.proto``; a reader refuses every other."""

UNSEQUENCED: Final = -1
"""Plant time of an unsequenced input's sequence start, and of the last break of a plant that had none."""

UNKNOWN_CLOCK: Final = 0
"""``clock_id`` of a sender that does not tell which clock it reads."""

VIRTUAL_CLOCK: Final = 1
"""``clock_id`` of every process of a lockstep run: they share the virtual clock."""

Vector: TypeAlias = tuple[float, ...]


class Record(Struct, frozen=True, gc=False):
    """Base of all records; at a dozen per tick, a frozen dataclass would cost ten times as much (decision 0003).

    Records hold numbers, text and other records, never a cycle, so garbage collection is disabled for them.
    """


class PlantPhase(IntEnum):
    """Origin of the plant's input: see ``passafe.proto``."""

    WAITING = 1
    RUNNING = 2
    HOLDING = 3
    FAIL_SAFE = 4


class FilterStatus(IntEnum):
    """Outcome of one filter tick: see ``passafe.proto``. Its numbers are in no order: see ``severity``."""

    PASSED = 1
    MODIFIED = 2
    RELAXED = 3
    UNCERTIFIED = 4
    INFEASIBLE = 5
    STALE = 6
    AT_SAMPLES = 7
    BACKUP = 8
    STOPPED = 9

    @property
    def severity(self) -> int:
        """Rank among all statuses, from 1, the best, on."""
        return BY_SEVERITY.index(self) + 1

    @property
    def is_fallback(self) -> bool:
        """True if a hard row is violated or may be, or if command or state are too old."""
        return self in _FALLBACKS


BY_SEVERITY: Final = (
    FilterStatus.PASSED,
    FilterStatus.MODIFIED,
    FilterStatus.RELAXED,
    FilterStatus.BACKUP,
    FilterStatus.STOPPED,
    FilterStatus.STALE,
    FilterStatus.AT_SAMPLES,
    FilterStatus.UNCERTIFIED,
    FilterStatus.INFEASIBLE,
)
"""All statuses, from best to worst."""

_FALLBACKS: Final = (
    FilterStatus.STALE,
    FilterStatus.AT_SAMPLES,
    FilterStatus.UNCERTIFIED,
    FilterStatus.INFEASIBLE,
)


class Header(Record, frozen=True):
    """Sender, number and times of a message."""

    source: str
    epoch: int
    sequence: int
    scheduled_ns: int
    started_ns: int
    sent_ns: int
    wall_ns: int
    clock_id: int = UNKNOWN_CLOCK


class CommandState(StrEnum):
    """Reason for which the operator's command counts at the filter, or does not."""

    NONE = "none"
    """No command has come yet."""

    COUNTS = "counts"
    """The newest command is in force."""

    RESUMES = "resumes"
    """Commands count again after a stale stretch and ramp in."""

    RELEASED = "released"
    """The dead-man switch is released."""

    SILENT = "silent"
    """No newer command came before the last one became stale."""

    DELAYED = "delayed"
    """Commands come, but are stale when they arrive."""

    STOPPED = "stopped"
    """An emergency stop is latched, or the command was made before it was cleared."""


class OperatorCommand(Record, frozen=True):
    """Command of the operator: ``u_h`` and, if the device provides it, its rate.

    The echo of a plant state bounds the command's age at a filter whose clock the operator does not read.
    """

    u_h: Vector
    u_h_rate: Vector
    enabled: bool
    device: str
    echoed_epoch: int = 0
    echoed_ns: int = 0
    echoed_for_ns: int = 0
    take_over: int = 0


class WhoDrives(StrEnum):
    """Driver that the page names."""

    PAGE = "page"
    """A page, by its commands."""

    NOBODY = "nobody"
    """Nobody: the page that drove released, or fell silent."""

    SCRIPT = "script"
    """The operator's own source: the scenario's script."""


class Steer(Record, frozen=True):
    """Driver that the page names, and its newest command.

    The echo of an operator's command bounds the age of this one at an operator whose clock the dashboard does not read.
    """

    turn: int
    driver: str
    page: int = 0
    shares: Vector = ()
    engaged: bool = False
    age_ns: int = 0
    take_over: bool = False
    echoed_epoch: int = 0
    echoed_ns: int = 0
    echoed_for_ns: int = 0


class EmergencyStop(Record, frozen=True):
    """Press of the emergency stop: the plant latches it until it is cleared by its id."""

    id: int
    reason: str


class StopClear(Record, frozen=True):
    """Clears the emergency stop of this id."""

    stop: int
    reason: str


class OperatorLease(Record, frozen=True):
    """Lease of the operator whose commands count; ``holder`` is the epoch of its session, 0 for nobody."""

    number: int
    holder: int
    device: str
    command_age_ns: int
    refused: int = 0


class PlantInput(Record, frozen=True):
    """Certified input of the filter, in force from ``effective_plant_ns`` on.

    An *input sequence* has one input for every period from ``input_sequence_start_ns`` on, each decided for the state
    to which the previous ones lead. ``previous_u`` repeats the newest of those, so that a lost message does not break
    the sequence.
    """

    tick: int
    u: Vector
    effective_plant_ns: int
    hold_ns: int
    input_sequence_start_ns: int = UNSEQUENCED
    known_break_ns: int = UNSEQUENCED
    previous_u: Vector = ()
    stops_cleared: int = 0


class GuardAction(StrEnum):
    """Answer of the plant's guard to the input that it was asked to pass."""

    NONE = ""
    """There is no guard, or nothing to guard."""

    PASSED = "passed"
    """The input is in force to the last bit."""

    CHANGED = "changed"
    """The nearest input that keeps every row is in force."""

    FAIL_SAFE = "fail-safe"
    """No input is certified to keep every row: the core's fallback is in force."""


class PlantState(Record, frozen=True):
    """State of the robot at ``plant_ns``; ``u`` is in force from then on."""

    plant_ns: int
    x: Vector
    y: Vector
    u: Vector
    applied_tick: int
    phase: PlantPhase
    energy_in_j: float
    energy_stored_j: float
    input_lead_ns: int
    inputs_late: int
    inputs_refused: int
    integration_error: float
    received_tick: int
    sequence_break_ns: int = UNSEQUENCED
    input_since_ns: int = 0
    input_transit_ns: int = 0
    input_epoch: int = 0
    stop: int = 0
    stop_source: str = ""
    stops_cleared: int = 0
    guard: str = ""
    u_asked: Vector = ()
    guard_cause: str = ""
    guarded: int = 0
    true_x: Vector = ()


class BarrierReport(Record, frozen=True):
    """ψ₀ … ψ_r of one barrier at the decision."""

    name: str
    psi: Vector
    eps: float = 0.0


class RowReport(Record, frozen=True):
    """One row of the quadratic program at the decision."""

    name: str
    margin: float
    dual: float
    active: bool
    share: float = 0.0
    relaxed: float = 0.0


class OverrideReport(Record, frozen=True):
    """Difference between the operator's request and the decision; ``held_back`` is empty if it is unknown."""

    held_back: Vector = ()
    allowed_fraction: float = 0.0
    unavoidable: bool = False
    distance_to_infeasibility: float = 0.0


class Certificate(Record, frozen=True):
    """Certificate of a solution, computed by the filter: residuals in units of u."""

    solver: str
    accepted: bool
    primal_residual: float
    dual_residual: float
    gap: float


class Consumed(Record, frozen=True):
    """Reference to a message that a step consumed, with which a log can be replayed."""

    topic: str
    sequence: int
    received_ns: int
    epoch: int
    term: int = 0


class FilterTick(Record, frozen=True):
    """Complete record of one filter tick."""

    tick: int
    status: FilterStatus
    mode: str
    law: str
    effective_plant_ns: int
    x_hat: Vector
    u_h: Vector
    u_h_rate: Vector
    u_nominal: Vector
    phi: Vector
    v: Vector
    u: Vector
    barriers: tuple[BarrierReport, ...]
    power_margin: float
    tank_j: float
    slack: float
    rows: tuple[RowReport, ...]
    certificate: Certificate
    consumed: tuple[Consumed, ...]
    state_age_ns: int
    command_age_ns: int
    override: OverrideReport = OverrideReport()
    horizon_ns: int = 0
    command_state: str = ""
    command_share: float = 0.0
    x_error: Vector = ()
    residual: Vector = ()


class LinkOutage(Record, frozen=True):
    """Outage of a link; times from its first message."""

    start_s: float
    end_s: float


class LinkParameters(Record, frozen=True):
    """Settings of one injected link on the wire: see ``passafe_protocol.link_settings``."""

    delay_s: float
    jitter_s: float
    distribution: str
    quantiles_s: Vector
    correlation: float
    reorder: bool
    loss: float
    burst_enter: float
    burst_leave: float
    burst_loss_good: float
    burst_loss_bad: float
    duplicate: float
    corrupt: float
    rate_hz: float
    queue: int
    outages: tuple[LinkOutage, ...]
    seed: int
    network: str = ""


class LinkConfig(Record, frozen=True):
    """Request to change the settings of a link."""

    link: str
    parameters: LinkParameters


class LinkEvent(Record, frozen=True):
    """Effect of a link on one message, other than delay."""

    link: str
    effect: str
    topic: str
    sequence: int
    cause: str = ""


class LinkSource(Record, frozen=True):
    """Messages of one session of a sender that entered a link."""

    source: str
    epoch: int
    first: int
    newest: int
    received: int


class LinkState(Record, frozen=True):
    """Settings in force of one link and counts of its messages."""

    link: str
    topic: str
    parameters: LinkParameters
    trace_opportunities: int
    entered: int
    delivered: int
    dropped_loss: int
    dropped_queue: int
    dropped_outage: int
    duplicated: int
    corrupted: int
    in_flight: int
    refused_corrupted: int
    refused_duplicate: int
    trigger: str
    config_source: str
    config_epoch: int
    config_sequence: int
    refusal: str
    sources: tuple[LinkSource, ...]


class TopicHealth(Record, frozen=True):
    """Message counts of one topic at one process since its start."""

    topic: str
    received: int
    gaps: int
    refused: int


class Health(Record, frozen=True):
    """Loop timing and message counts of a process, published once per second."""

    rate_hz: float
    steps: int
    overruns: int
    steps_skipped: int
    late_us_max: float
    topics: tuple[TopicHealth, ...]


class EventKind(StrEnum):
    """Kind of an event that carries numbers, for programs."""

    TEXT = ""
    """None: the text says it all."""

    MODEL_VIOLATED = "MODEL_VIOLATED"
    """A plant state lies outside of what the scenario's sets allow from the ones before."""


class Event(Record, frozen=True):
    """Human-readable event; some kinds carry their numbers, too."""

    severity: str
    text: str
    kind: str = ""
    number: int = 0
    axis: str = ""
    factor: float = 0.0


class ScenarioInfo(Record, frozen=True):
    """Effective configuration of a run."""

    scenario_json: str
    driver: str
    versions_json: str


Message: TypeAlias = (
    OperatorCommand
    | Steer
    | EmergencyStop
    | StopClear
    | OperatorLease
    | PlantInput
    | PlantState
    | FilterTick
    | LinkConfig
    | LinkEvent
    | LinkState
    | Health
    | Event
    | ScenarioInfo
)


class Received(Record, frozen=True):
    """Message received by a node, with the time at which it left its link.

    ``term`` orders the sessions of its sender: it counts the changes of session that the process had seen when the
    message entered the link. Epochs do not order them.
    """

    header: Header
    body: Message
    received_ns: int
    term: int = 0
