"""Record of one filter tick: request, decision and what it rests on."""

from enum import IntEnum, StrEnum
from typing import Final

from passafe_protocol.messages.record import Record, Vector


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
