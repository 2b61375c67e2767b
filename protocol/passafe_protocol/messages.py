"""The messages as Python values: one immutable record for each message of ``passafe.proto``.

Nodes speak these and never protobuf, so that a closed loop in one process pays for no encoding. Field names, units and
meanings are those of ``passafe.proto``; the header travels beside the body.
"""

from enum import IntEnum
from typing import Final, TypeAlias

from msgspec import Struct

SCHEMA_VERSION: Final = 2
"""Version of ``passafe.proto``; a reader refuses every other."""

UNSEQUENCED: Final = -1
"""Plant time where there is none: an input of no arming, a plant that was never disarmed."""

Vector: TypeAlias = tuple[float, ...]


class Record(Struct, frozen=True, gc=False):
    """Base of all of them: what a tick makes a dozen of costs a tenth of a frozen dataclass (decision 0003).

    Records hold numbers, text and other records, never a cycle, so the garbage collector need not look at them.
    """


class PlantPhase(IntEnum):
    """What decides the plant's input: see ``passafe.proto``."""

    WAITING = 1
    RUNNING = 2
    HOLDING = 3
    FAIL_SAFE = 4


class FilterStatus(IntEnum):
    """Outcome of one filter tick: see ``passafe.proto``."""

    PASSED = 1
    MODIFIED = 2
    RELAXED = 3
    UNCERTIFIED = 4
    INFEASIBLE = 5
    STALE = 6


class Header(Record, frozen=True):
    """Who sent a message, which one it is, and when."""

    source: str
    epoch: int
    sequence: int
    scheduled_ns: int
    started_ns: int
    sent_ns: int
    wall_ns: int


class OperatorCommand(Record, frozen=True):
    """What the person asks for: ``u_h`` and, if the device knows it, its rate."""

    u_h: Vector
    u_h_rate: Vector
    enabled: bool
    device: str


class PlantInput(Record, frozen=True):
    """What the filter lets the robot do, from ``effective_plant_ns`` on.

    An *input sequence* is unbroken: one input for every period from ``input_sequence_start_ns`` on, each made for
    the state to which the ones before it lead. ``previous_u`` repeats the newest of those, so that one lost message
    does not break the sequence.
    """

    tick: int
    u: Vector
    effective_plant_ns: int
    hold_ns: int
    input_sequence_start_ns: int = UNSEQUENCED
    known_break_ns: int = UNSEQUENCED
    previous_u: Vector = ()


class PlantState(Record, frozen=True):
    """What the robot is doing at ``plant_ns``; ``u`` is in force from then on."""

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
    """What the filter changed, and what would have passed; ``held_back`` is empty where that is not known."""

    held_back: Vector = ()
    allowed_fraction: float = 0.0
    unavoidable: bool = False
    distance_to_infeasibility: float = 0.0


class Certificate(Record, frozen=True):
    """Our own judgement of the solver's answer: residuals in units of u."""

    solver: str
    accepted: bool
    primal_residual: float
    dual_residual: float
    gap: float


class Consumed(Record, frozen=True):
    """A message that a step consumed: enough to feed the step again from a log."""

    topic: str
    sequence: int
    received_ns: int
    epoch: int


class FilterTick(Record, frozen=True):
    """Everything the filter did in one tick, and why."""

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


class LinkOutage(Record, frozen=True):
    """A time in which a link carries nothing, from its first message on."""

    start_s: float
    end_s: float


class LinkParameters(Record, frozen=True):
    """Settings of one injected link as they cross the wire: see ``passafe_protocol.link_settings``."""

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


class LinkConfig(Record, frozen=True):
    """Asks for other settings of a link."""

    link: str
    parameters: LinkParameters


class LinkEvent(Record, frozen=True):
    """What a link did to one message."""

    link: str
    effect: str
    topic: str
    sequence: int
    cause: str = ""


class LinkSource(Record, frozen=True):
    """Which messages of one session of a sender were put into a link."""

    source: str
    epoch: int
    first: int
    newest: int
    received: int


class LinkState(Record, frozen=True):
    """Settings in force of one link, and what became of its messages."""

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
    """What one process saw of one topic since its start."""

    topic: str
    received: int
    gaps: int
    refused: int


class Health(Record, frozen=True):
    """How one process is doing; published once per second."""

    rate_hz: float
    steps: int
    overruns: int
    steps_skipped: int
    late_us_max: float
    topics: tuple[TopicHealth, ...]


class Event(Record, frozen=True):
    """Something that happened, in words."""

    severity: str
    text: str


class ScenarioInfo(Record, frozen=True):
    """The effective configuration of a run."""

    scenario_json: str
    driver: str
    versions_json: str


Message: TypeAlias = (
    OperatorCommand
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
    """A message as it came out of its link: what a node's inbox holds."""

    header: Header
    body: Message
    received_ns: int
