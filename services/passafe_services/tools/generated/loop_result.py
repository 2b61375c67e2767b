"""The result of one generated loop."""

from typing import Final

from pydantic import Field

from passafe_services.tools.runs.record import SweepRecord

ROUNDING: Final = 1e-8
"""h below zero by no more than this, relative to 1 + |h| at the start, is rounding of filter and integration."""

LIMIT_ROUNDING: Final = 1e-9
"""An input beyond a limit by no more than this share of it is rounding."""

TANK_ROUNDING: Final = 1e-8
"""A tank below its bound by no more than this share of its first level is rounding."""


class LoopResult(SweepRecord):
    """The result of one loop.

    Attributes:
        seed: Seed that repeats it.
        family: Family of its plant.
        rate_hz: Ticks per second.
        hold_s: Longest time for which an input is held, s.
        oracle_share: Share of random protected states in which some admissible input keeps all rows.
        refusal: Why the filter was not built; empty if it was.
        warnings: What the check of the design found; empty if it was clean.
        gatekeeper: Whether the filter had one.
        gatekeeper_advised: Whether it was drawn without and has one because its check warned: with it, the check is
            clean.
        started_inside: Whether the start was in the protected set.
        start_warning: What a check of this very start found; empty if it was clean, or not made because nothing went
            wrong.
        operator: Name of the operator.
        lost: Inputs that did not arrive.
        ticks: Decisions taken.
        statuses: How many of each.
        h_start: Least h at the start.
        h_min: Least h at and between samples.
        psi_min: Least ψ₀ … ψ_{r−1} at and between samples.
        tank_min_j: Least energy in the tank at and between samples, J; ``None`` without a tank.
        tank_start_j: Energy in it at the start, J; 0 without one.
        accounted_min_j: Least of tank + ∫slack − reserve, J; ``None`` without a tank.
        overreach: Largest share by which an input was beyond a limit; 0 or less within all.
        fallback_ticks: Decisions that were a fallback.
        entries: How often a fallback was entered.
        braking_better: Of the entries that were compared, those from which braking alone keeps h longer, or larger.
    """

    seed: int
    family: str
    rate_hz: float
    hold_s: float
    oracle_share: float
    refusal: str = ""
    warnings: tuple[str, ...] = ()
    gatekeeper: bool = False
    gatekeeper_advised: bool = False
    started_inside: bool = False
    start_warning: str = ""
    operator: str = ""
    lost: int = 0
    ticks: int = 0
    statuses: dict[str, int] = Field(default_factory=dict)
    h_start: float = 0.0
    h_min: float = 0.0
    psi_min: float = 0.0
    tank_min_j: float | None = None
    tank_start_j: float = 0.0
    accounted_min_j: float | None = None
    overreach: float = -1.0
    fallback_ticks: int = 0
    entries: int = 0
    braking_better: int = 0

    @property
    def is_refused(self) -> bool:
        """True if there is no loop, because the core refused the design."""
        return bool(self.refusal)

    @property
    def is_accepted(self) -> bool:
        """True if the design was built and its check was clean."""
        return not self.refusal and not self.warnings

    @property
    def counts(self) -> bool:
        """True if the filter promises h ≥ 0: an accepted design, and a start in the protected set without a warning."""
        return self.is_accepted and self.started_inside and not self.start_warning

    @property
    def is_safe(self) -> bool:
        """True if h stayed at or above zero, up to rounding."""
        return self.h_min >= -ROUNDING * (1 + abs(self.h_start))

    @property
    def is_solvent(self) -> bool:
        """True if the tank never fell below zero, or below its reserve by more than the slack accounts for."""
        if self.tank_min_j is None or self.accounted_min_j is None:
            return True
        least_j = -TANK_ROUNDING * self.tank_start_j
        return self.tank_min_j >= least_j or self.accounted_min_j >= least_j

    @property
    def is_within_limits(self) -> bool:
        """True if no input was beyond a limit, up to rounding."""
        return self.overreach <= LIMIT_ROUNDING
