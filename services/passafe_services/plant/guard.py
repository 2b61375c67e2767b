"""Guard at the plant: the safety rows once more, on the plant's own state, as the last thing before the actuator."""

from typing import Final

from msgspec import Struct
from passafe_protocol.messages import Event, GuardAction, Vector

from passafe.decision import ANSWERS, Decision, Status
from passafe.filter import SafetyPassivityFilter
from passafe.state_set import ErrorGrowth
from passafe_services.plant_contract.state_estimate import StateEstimate

QUIET_PERIOD_NS: Final = 1_000_000_000
"""Least time between two events of the guard, ns."""

ROUNDING: Final = 1e-9
"""Relative rounding of a step that a filter has led to a limit of the rate."""

FALLBACK: Final = "fallback"
"""Cause where no input is certified to keep every row."""


class Guarded(Struct, frozen=True, gc=False):
    """Answer of the guard to one input.

    Attributes:
        u: Input to apply: the one asked, to the last bit, if it passed.
        action: What the guard did.
        cause: Name of the row that stood in the way most; empty if none did.
    """

    u: Vector
    action: GuardAction
    cause: str


class Guard:
    """Lets an input through if it keeps every row of the safe set on the plant's own state, else the nearest that does.

    It trusts nobody: neither that a filter certified the input, nor that there is a filter. Where no input is certified
    to keep every row, the core's fallback acts, which ends in the fail-safe law.

    Attributes:
        changed: Periods whose input it has changed.
    """

    def __init__(self, core: SafetyPassivityFilter, growth: ErrorGrowth | None = None, *, period_ns: int = 0) -> None:
        """Start with nothing changed.

        Args:
            core: Rows of the guard, whose nominal input is what is asked (``guard_design_of``).
            growth: Growth of errors by the guard's sets, if it has any.
            period_ns: Period of the plant, ns.
        """
        self._estimate = None if growth is None else StateEstimate(growth)
        self._period_ns = period_ns
        self._judged_ns: int | None = None
        self._core = core
        design, m = core.design, core.design.system.m
        self._still: Vector = (0.0,) * m
        fall, rise = design.limits.fall_per_s, design.limits.rise_per_s
        self._steps = None if fall is None or rise is None else _steps(fall, rise, design.dt_s)
        self.changed = 0
        self._reported = ""
        self._quiet_until_ns = 0

    def judge(self, x: Vector, before: Vector, asked: Vector, plant_ns: int) -> Guarded:
        """Return the input to apply from now on.

        Args:
            x: State as the plant reads it, n numbers.
            before: Input in force until now, m numbers.
            asked: Input to pass, m numbers.
            plant_ns: Plant time, ns.
        """
        core, still, t_s = self._core, self._still, plant_ns * 1e-9
        # As if it had been in force already: then margins are those about it, and the law asks for nothing else.
        error: Vector | None = None
        if self._estimate is not None:
            follows = self._judged_ns is not None and plant_ns - self._judged_ns == self._period_ns
            known = self._estimate.observe(x, (before,) if follows else None)
            x, error, self._judged_ns = known.center, known.radius, plant_ns
        decision = core.decide(x, asked, asked, still, 0.0, t_s, x_error=error)
        steps = self._steps
        if (
            decision.status is Status.PASSED
            and decision.u == asked
            and (steps is None or _can_follow(before, asked, steps))
        ):
            return Guarded(asked, GuardAction.PASSED, "")
        if steps is not None:
            decision = core.decide(x, before, asked, still, 0.0, t_s, x_error=error)
        self.changed += 1
        if decision.status in ANSWERS:
            return Guarded(decision.u, GuardAction.CHANGED, self._cause(decision))
        return Guarded(decision.u, GuardAction.FAIL_SAFE, FALLBACK)

    def event(self, guarded: Guarded, plant_ns: int) -> Event | None:
        """Return an event if the guard has begun to act for another cause, at most once a second."""
        if guarded.action is GuardAction.PASSED or plant_ns < self._quiet_until_ns:
            return None
        is_known, self._reported = guarded.cause == self._reported, guarded.cause
        self._quiet_until_ns = plant_ns + QUIET_PERIOD_NS
        if is_known:
            return None
        at = f"plant time {plant_ns / 1e9:.3f} s"
        if guarded.action is GuardAction.FAIL_SAFE:
            return Event("error", f"guard: no input is certified to keep every row, fallback in force at {at}")
        return Event("warning", f"guard: changed the input for {guarded.cause} at {at}")

    def _cause(self, decision: Decision) -> str:
        """Return the name of the row with the largest multiplier."""
        return self._core.row_names[int(decision.duals.argmax())]


def _steps(fall: Vector, rise: Vector, dt_s: float) -> list[tuple[float, float]]:
    """Return the least and largest step of each axis in a period, rounding included."""
    return [(-dt_s * down * (1 + ROUNDING), dt_s * up * (1 + ROUNDING)) for down, up in zip(fall, rise, strict=True)]


def _can_follow(before: Vector, asked: Vector, steps: list[tuple[float, float]]) -> bool:
    """Return whether limits of the rate permit the step to what is asked."""
    return all(low <= now - was <= high for was, now, (low, high) in zip(before, asked, steps, strict=True))
