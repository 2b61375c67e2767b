"""The design of a filter: plant, feedback, barriers, passivity, law and mode."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum
from math import ceil, inf
from typing import Final, TypeVar

import casadi as ca

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.arguments.axis_limits import PerAxis
from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described, members, one_number
from passafe.arguments.ranges import require_positive, yes_or_no
from passafe.barrier_chain import Barrier
from passafe.certificate import Tolerance
from passafe.enclosures.jumps import require_finite_constants, require_no_jumps
from passafe.errors import DesignError
from passafe.expressions.storage_sign import require_lower_bound
from passafe.limits import Limits
from passafe.passivity import Passivity
from passafe.system import System
from passafe.uncertainty import Uncertainty

Member = TypeVar("Member", bound=Enum)

SLACK_PERIODS: Final = 1e-9
"""Rounding of the number of periods that a hold takes."""

LONGEST_HOLD: Final = 2048
"""Periods for which an input may stay in force, at most."""


class Law(Enum):
    """Rows of the quadratic program.

    The sampled law puts ψ_r and h_u on the input that is held over the next period; the continuous law is the
    paper's, which puts their time derivatives on v and can diverge (``docs/theory.md``, section 4).
    """

    SAMPLED = "sampled"
    CONTINUOUS = "continuous"


class Mode(Enum):
    """Properties that the filter enforces."""

    OFF = "off"
    SAFE = "safe"
    PASSIVE = "passive"
    BOTH = "both"

    @property
    def enforces_safety(self) -> bool:
        """True if the barriers' rows are in the quadratic program."""
        return self in {Mode.SAFE, Mode.BOTH}

    @property
    def enforces_passivity(self) -> bool:
        """True if the passivity row is in the quadratic program."""
        return self in {Mode.PASSIVE, Mode.BOTH}


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class FilterDesign:
    """Everything that a safety and passivity filter is derived from.

    Attributes:
        system: The plant.
        u_fb: State feedback, expression of x, shape (m, 1): SX, numbers, or a sequence of them. None if not given: the
            operator alone drives.
        fail_safe: The plant's own law, used where no answer is accepted, expression of x, shape (m, 1), given likewise.
            If it is not given, no input: that brakes a plant which dissipates, and no other.
        barriers: Any number, with unique names; any sequence.
        passivity: Storage function and passivity row; the power margin is reported in every mode.
        k_i: α/2 of the tracking term, 1/s.
        dt_s: Period, s: how long an input is in force when the next one follows in time.
        input_bound: Largest magnitude of u: one number for every axis, or one for each.
        input_norm_bound: Largest ‖u‖, if that is limited too.
        input_rate_bound_per_s: Largest rate of change of u: one number for every axis, or one for each.
        input_low: Least u, in the place of −``input_bound``: one number for every axis, or one for each. Zero need not
            be within the limits.
        input_high: Largest u, in the place of ``input_bound``, which may be left out where both are given.
        input_norms: Limits of the norm over some axes each.
        input_half_spaces: Limits of weighted sums of the axes; several make a polytope.
        input_rate_low_per_s: Least rate of change of u, negative, in the place of −``input_rate_bound_per_s``.
        input_rate_high_per_s: Largest one, positive, likewise; a side that nothing limits has no limit.
        law: Kind of rows; the member or its value.
        mode: Properties that are enforced; the member or its value.
        between_samples: Whether the sampled law's rows have the margin that keeps barriers between samples too.
        hold_s: How long an input may stay in force where no other follows, s; one period if not given. The margin
            between samples covers all of it.
        gatekeeper: Whether an input is sent only if from where it leads the fail-safe law is proven to keep every
            barrier; otherwise that law's own input is sent (``docs/theory.md``, section 8).
        tolerance: Residuals up to which an answer is accepted.
        uncertainty: Sets for whose every member the rows are to hold; None for a plant that is its model.
        limits: Limits of the actuators that all bounds amount to.
    """

    system: System
    u_fb: ca.SX = field(default_factory=lambda: ca.SX(0, 0))
    fail_safe: ca.SX = field(default_factory=lambda: ca.SX(0, 0))
    barriers: tuple[Barrier, ...]
    passivity: Passivity
    k_i: float
    dt_s: float
    input_bound: PerAxis | None = None
    input_norm_bound: float | None = None
    input_rate_bound_per_s: PerAxis | None = None
    input_low: PerAxis | None = None
    input_high: PerAxis | None = None
    input_norms: Sequence[NormBound] = ()
    input_half_spaces: Sequence[HalfSpace] = ()
    input_rate_low_per_s: PerAxis | None = None
    input_rate_high_per_s: PerAxis | None = None
    law: Law = Law.SAMPLED
    mode: Mode = Mode.BOTH
    between_samples: bool = True
    hold_s: float | None = None
    gatekeeper: bool = False
    tolerance: Tolerance = field(default_factory=Tolerance)
    uncertainty: Uncertainty | None = None
    limits: Limits = field(init=False)

    def __post_init__(self) -> None:
        """Take parts in every form that is allowed, and refuse what does not fit together."""
        self._take_parts()
        self._take_numbers()
        object.__setattr__(self, "limits", self._limits())
        self._take_uncertainty()
        names = [barrier.name for barrier in self.barriers]
        if len(set(names)) != len(names):
            raise DesignError("barriers", f"the names {names}", "each name once")
        self._refuse_jumps()
        if self.mode.enforces_passivity:
            self.system.require_state_function("storage V", self.passivity.V, 1)
            require_lower_bound(self.passivity.V, self.system.x)

    def _take_parts(self) -> None:
        for name, kind in (("system", System), ("passivity", Passivity), ("tolerance", Tolerance)):
            if not isinstance(getattr(self, name), kind):
                raise DesignError(name, described(getattr(self, name)), f"a {kind.__name__}")
        object.__setattr__(self, "barriers", _barriers(self.barriers))
        object.__setattr__(self, "law", _member(Law, "law", self.law))
        object.__setattr__(self, "mode", _member(Mode, "mode", self.mode))
        for name in ("between_samples", "gatekeeper"):
            object.__setattr__(self, name, yes_or_no(name, getattr(self, name)))
        for name in ("u_fb", "fail_safe"):
            given = as_column(name, getattr(self, name))
            law = ca.SX.zeros(self.system.m) if given.shape == (0, 0) else given
            self.system.require_state_function(name, law, self.system.m)
            object.__setattr__(self, name, law)

    def _take_uncertainty(self) -> None:
        if self.uncertainty is None:
            return
        if not isinstance(self.uncertainty, Uncertainty):
            raise DesignError("uncertainty", described(self.uncertainty), "an Uncertainty, or None")
        self.uncertainty.require_fits(self.system)
        if self.law is not Law.SAMPLED or not self.between_samples or self.gatekeeper:
            got = f"law {self.law.value}, between_samples {self.between_samples}, gatekeeper {self.gatekeeper}"
            raise DesignError("uncertainty", got, "law sampled with between_samples, without gatekeeper")
        if self.uncertainty.actuator_lag_s and inf in (
            *(self.limits.fall_per_s or (inf,)),
            *(self.limits.rise_per_s or ()),
        ):
            raise DesignError(
                "uncertainty actuator_lag_s",
                f"{self.uncertainty.actuator_lag_s:g} s without limits of all rates of the input",
                "a lag with input_rate_bound_per_s, which bounds what the lag makes of an input; or input_error",
            )

    def _refuse_jumps(self) -> None:
        """Refuse what has no derivative wherever one is taken; the fail-safe law is only evaluated."""
        require_no_jumps("dynamics f", self.system.f)
        require_no_jumps("output y", self.system.port_y)
        require_no_jumps("port_u", self.system.port_u)
        require_no_jumps("feedback u_fb", self.u_fb)
        require_no_jumps("storage V", self.passivity.V)
        for barrier in self.barriers:
            require_no_jumps(f"barrier {barrier.name!r} h", barrier.h)
        require_finite_constants("fail_safe", self.fail_safe)

    def _take_numbers(self) -> None:
        require_positive("k_i", self.k_i)
        require_positive("dt_s", self.dt_s)
        for name in ("k_i", "dt_s"):
            object.__setattr__(self, name, one_number(name, getattr(self, name)))
        if self.k_i * self.dt_s >= 1.0:
            raise DesignError("k_i", self.k_i, f"less than 1/dt_s = {1 / self.dt_s:g}, or the tracking oscillates")
        if self.hold_s is not None:
            object.__setattr__(self, "hold_s", one_number("hold_s", self.hold_s))
            if not 0.0 <= self.hold_s <= LONGEST_HOLD * self.dt_s:
                allowed = f"a number from zero to {LONGEST_HOLD} periods, {LONGEST_HOLD * self.dt_s:g} s"
                raise DesignError("hold_s", self.hold_s, allowed)

    def _limits(self) -> Limits:
        return Limits.of(
            self.system.m,
            self.input_bound,
            self.input_norm_bound,
            self.input_rate_bound_per_s,
            low=self.input_low,
            high=self.input_high,
            norms=self.input_norms,
            half_spaces=self.input_half_spaces,
            rate_low_per_s=self.input_rate_low_per_s,
            rate_high_per_s=self.input_rate_high_per_s,
        )

    @property
    def held_s(self) -> float:
        """Longest time for which an input is in force, s: the longer of ``dt_s`` and ``hold_s``."""
        return max(self.dt_s, self.hold_s or 0.0)

    @property
    def held_periods(self) -> int:
        """Number of periods that ``held_s`` takes, rounded up."""
        return max(1, ceil(self.held_s / self.dt_s - SLACK_PERIODS))


def _barriers(given: object) -> tuple[Barrier, ...]:
    """Return the barriers of any iterable of them."""
    found = members(given)
    if found is None:
        raise DesignError("barriers", described(given), "a sequence of Barrier")
    barriers = tuple(each for each in found if isinstance(each, Barrier))
    if len(barriers) < len(found):
        other = next(each for each in found if not isinstance(each, Barrier))
        raise DesignError("barriers", described(other), "a sequence of Barrier")
    return barriers


def _member(kind: type[Member], name: str, given: object) -> Member:
    """Return a member of an enumeration, given as such or by its value."""
    for member in kind:
        if given is member or (isinstance(given, str) and given == member.value):
            return member
    raise DesignError(name, described(given), f"{kind.__name__} or one of {[member.value for member in kind]}")
