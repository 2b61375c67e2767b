"""The energy tank: energy that the robot was given and has not yet used (Duindam & Stramigioli 2004)."""

from dataclasses import dataclass
from math import inf

import numpy as np

from passafe.arguments.numbers import one_number
from passafe.arguments.ranges import require_positive
from passafe.errors import DesignError
from passafe.numerics.workspace import Array


@dataclass(frozen=True, kw_only=True, slots=True)
class Tank:
    """An energy ledger E with a ceiling and a reserve.

    E ← min(E + ∫yᵀu dt − ΔV, E_max). While E ≥ 0 the plant has given out no more than it was given plus E(0).

    Attributes:
        initial_j: E(0), J.
        reserve_j: E_r, J: the passivity row lets only safety draw on it.
        max_j: E_max, J: energy beyond it is forgotten, so that a long dissipation buys no later burst.
        rate_per_s: κ, 1/s: how fast the tank may be emptied towards the reserve.
    """

    initial_j: float = 1.0
    reserve_j: float = 0.5
    max_j: float = 10.0
    rate_per_s: float = 5.0

    def __post_init__(self) -> None:
        """Refuse ledgers that cannot work."""
        for name in ("initial_j", "reserve_j", "max_j"):
            object.__setattr__(self, name, one_number(f"tank {name}", getattr(self, name)))
        if not 0.0 <= self.reserve_j <= self.initial_j <= self.max_j < inf:
            got = f"reserve {self.reserve_j}, initial {self.initial_j}, max {self.max_j}"
            raise DesignError("tank energies", got, "0 ≤ reserve ≤ initial ≤ max, finite, J")
        require_positive("tank rate_per_s", self.rate_per_s, "1/s")

    def balance(self, level_j: float, energy_in_j: float, stored_change_j: float) -> float:
        """Return the level after a period: min(E + ∫yᵀu − ΔV, E_max), J.

        Args:
            level_j: E before the period, J.
            energy_in_j: ∫yᵀu dt over the period, J.
            stored_change_j: V after minus V before, J.
        """
        level_j += energy_in_j - stored_change_j
        return min(self.max_j, level_j)

    def balance_many(self, level_j: Array, energy_in_j: Array, stored_change_j: Array) -> Array:
        """Return ``balance`` of many ledgers, J; a NaN stays one.

        Args:
            level_j: E of each before the period, J.
            energy_in_j: ∫yᵀu dt over the period, J.
            stored_change_j: V after minus V before, J.
        """
        after: Array = np.minimum(self.max_j, level_j + (energy_in_j - stored_change_j))
        return after
