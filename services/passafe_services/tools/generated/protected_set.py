"""The set that a design's rows protect: all ψ₀ … ψ_{r−1} ≥ 0, derived here from the known relative degrees."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array
from passafe.system import System
from passafe_services.tools.generated.generated_plant import BarrierOffer, GeneratedPlant
from passafe_services.tools.generated.random_numbers import log_uniform

DRAWS: Final = 4000
SMALLEST: Final = 0.02
"""States are drawn from the plant's box, shrunk towards its middle by a factor between this and one."""

BISECTIONS: Final = 30
INSIDE: Final = 1e-9
"""ψ of a state that counts as inside, at least: bisection ends a hair from the boundary."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class RandomChain:
    """ψ₀ … ψ_r of one barrier with linear class-K functions.

    Attributes:
        offer: The barrier.
        gains: γ₁ … γ_{r+1}, 1/s.
        psi: Expressions of x and t, and of u the last.
        held: ψ_r with γ_r(p) no more than p/T for p > 0: more would let p jump over zero while the input is held.
    """

    offer: BarrierOffer
    gains: tuple[float, ...]
    psi: tuple[ca.SX, ...]
    held: ca.SX

    @classmethod
    def of(cls, system: System, offer: BarrierOffer, gains: Sequence[float], held_s: float) -> "RandomChain":
        """Derive the chain: ψᵢ = ψ̇ᵢ₋₁ + γᵢ·ψᵢ₋₁. What rounding leaves of u before its time is dropped."""
        psi = [offer.h]
        for gain in gains[: offer.degree - 1]:
            psi.append(ca.substitute(system.rate(psi[-1]) + gain * psi[-1], system.u, 0))
        p, gain = psi[-1], gains[offer.degree - 1]
        psi.append(system.rate(p) + gain * p)
        held = system.rate(p) + (gain * p if gain * held_s <= 1 else ca.fmin(gain * p, p / held_s))
        return cls(offer=offer, gains=tuple(gains), psi=tuple(psi), held=held)


class ProtectedSet:
    """Draws states inside, at the boundary and outside."""

    def __init__(self, plant: GeneratedPlant, chains: Sequence[RandomChain]) -> None:
        """Compile the ψ.

        Args:
            plant: Gives the box.
            chains: Of its barriers.
        """
        self._low, self._high = np.array(plant.low), np.array(plant.high)
        self._middle = (self._low + self._high) / 2
        system = plant.system
        protected = ca.vertcat(*(psi for chain in chains for psi in chain.psi[:-1]))
        self._psi = ca.Function("psi", [system.x, system.t], [ca.mmin(protected)])
        h = ca.mmin(ca.vertcat(*(chain.psi[0] for chain in chains)))
        self._h = ca.Function("h", [system.x, system.t], [h])

    def depth(self, states: Array, t_s: float = 0.0) -> Array:
        """Return the least ψ of states, shape (count,); negative outside.

        Args:
            states: Shape (n, count).
            t_s: Time, s.
        """
        return np.asarray(self._psi(ca.DM(states), t_s)).ravel()

    def least_h(self, x: Array) -> float:
        """Return the least h in one state at time zero."""
        return float(self._h(ca.DM(x), 0.0))

    def draw(self, rng: np.random.Generator, count: int = DRAWS, smallest: float = SMALLEST) -> tuple[Array, Array]:
        """Return random states inside and others outside, shapes (n, …).

        Args:
            rng: Source.
            count: How many states are drawn for both.
            smallest: Least factor by which the box is shrunk; 1 for all of the box alike.
        """
        shrink = np.exp(rng.uniform(np.log(smallest), 0.0, count))
        reach = (self._high - self._low)[:, None] / 2
        states = self._middle[:, None] + shrink * reach * rng.uniform(-1.0, 1.0, (len(self._low), count))
        is_inside = self.depth(states) > INSIDE
        return states[:, is_inside], states[:, ~is_inside]

    def boundary(self, inside: Array, outside: Array) -> Array:
        """Return a state just inside the boundary, between one inside and one outside, shape (n,)."""
        for _ in range(BISECTIONS):
            middle = (inside + outside) / 2
            if self.depth(middle[:, None])[0] > INSIDE:
                inside = middle
            else:
                outside = middle
        return inside


def draw_gains(rng: np.random.Generator, degree: int, largest_per_s: float, least_per_s: float) -> tuple[float, ...]:
    """Draw γ₁ … γ_{r+1}, 1/s: alike, within a factor of three."""
    middle = log_uniform(rng, least_per_s, largest_per_s)
    drawn = middle * np.exp(rng.uniform(-0.5, 0.5, degree + 1) * np.log(3.0))
    return tuple(np.clip(drawn, least_per_s, largest_per_s).tolist())
