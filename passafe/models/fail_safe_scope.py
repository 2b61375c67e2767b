"""Barriers that a robot's fail-safe law keeps, in numbers that a barrier can be held against."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

from passafe.arguments.numbers import described, numbers
from passafe.arguments.ranges import require_not_negative
from passafe.class_k import ClassK, Linear
from passafe.errors import DesignError

ROUNDING: Final = 1e-9
"""Relative difference up to which a gain counts as one that is kept."""


@dataclass(frozen=True, kw_only=True, slots=True)
class FailSafeScope:
    """Barriers of the position that a fail-safe law keeps when each of its inputs is held for ``dt_s``.

    Attributes:
        dt_s: How long each of its inputs is held, s; 0 for a law that is followed at every instant.
        kept_gains: Largest linear gains γ₁, γ₂, … of the chain of a barrier that is kept, 1/s. Zero where none is.
        top_speed: Largest speed at which it begins, m/s or rad/s.
    """

    dt_s: float = 0.0
    kept_gains: tuple[float, ...]
    top_speed: float = inf

    def __post_init__(self) -> None:
        """Refuse times, gains and speeds that are none."""
        require_not_negative("fail-safe scope dt_s", self.dt_s, "s")
        gains = numbers("fail-safe scope kept_gains", self.kept_gains)
        if not gains:
            raise DesignError("fail-safe scope kept_gains", "no numbers", "the largest gains that are kept, 0 for none")
        for gain in gains:
            require_not_negative("fail-safe scope kept_gains", gain, "1/s")
        object.__setattr__(self, "kept_gains", gains)
        speed = numbers("fail-safe scope top_speed", self.top_speed, "one number")
        if len(speed) != 1 or not speed[0] >= 0:
            raise DesignError("fail-safe scope top_speed", described(self.top_speed), "zero or a positive number")
        object.__setattr__(self, "top_speed", speed[0])

    def keeps(self, class_k: Sequence[ClassK]) -> bool:
        """Return whether a chain with these functions is within ``kept_gains``: linear, and no steeper."""
        shaping = class_k[: len(self.kept_gains)]
        return all(
            isinstance(gamma, Linear) and gamma.gain <= kept * (1 + ROUNDING)
            for gamma, kept in zip(shaping, self.kept_gains, strict=False)
        )
