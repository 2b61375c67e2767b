"""Relative degrees: does the input reach a time derivative of h, by structure, by value, by scale?

Structure alone keeps terms that cancel, such as (x + 1)u − xu − u; a single state and an absolute threshold mistake a
weak effect for none, or rounding for an effect. So ∂/∂u of the derivative is simplified, then evaluated at many states
in general position, each of them a few times with its last digits changed: rounding jumps about, an effect stays.

An effect that is there may still be none to build on. ẋ₁ = x₂ + 1e-10·u, ẋ₂ = u has relative degree 1 for h = x₁, and
only inputs of 1e10 keep a row in its first derivative. The direct effect g_k of each axis of u is therefore compared
with that in the next derivative, g_{k+1}, over the time 1/γ that the chain itself gives: what matters is

    (k + 1) γ |g_k| / |g_{k+1}|,

which has no unit, whatever those of h, u and time are.
"""

from dataclasses import dataclass
from math import inf
from typing import Final

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array
from passafe.system import System

ROUNDING: Final = 1e-13
"""Ratio below which an effect counts as none: constants that do not cancel to the last bit."""

TOO_WEAK: Final = 1e-6
"""Ratio below which a direct effect is not one to build on."""

DOUBTFUL: Final = 1e-3
"""Ratio below which it is worth a warning."""

SHIFTS: Final = 5
SHIFT: Final = 1e-10
"""Relative change of a state by which rounding is distinguished from an effect."""

STEADY: Final = 0.1
"""Spread of a gradient under such changes, relative to its size, up to which it is an effect."""

FEWEST: Final = 0.2
"""Share of the states with a finite gradient at which it has to be one."""

INPUT_SIZES: Final = tuple(
    sign * size for size in (1.0, 3, 10, 30, 0.3, 0.1, 100, 300, 0.03, 0.01, 1e3) for sign in (1, -1)
)
"""Sizes of the probes' inputs, in this order until one has an effect: in a dead zone or a saturation none has."""

SIZES: Final = (1, 0.1, 10, 100, 1e-3, 1e4)
"""Sizes of the states that are tried where h is defined at none of the first ones, as √x₀ is."""


@dataclass(frozen=True, kw_only=True, slots=True)
class InputReach:
    """Path of the input to the first derivative of h that contains it.

    Attributes:
        degree: Number of the derivative, the relative degree.
        how: ``structure`` where u stands in it whatever the state; ``values`` where terms had to be evaluated.
        ratio: Largest ratio of the direct effect to that of the next derivative; infinite where that has none.
    """

    degree: int
    how: str
    ratio: float

    @property
    def is_too_weak(self) -> bool:
        """Return whether the direct effect is not one to build on."""
        return self.ratio < TOO_WEAK

    @property
    def is_doubtful(self) -> bool:
        """Return whether the direct effect is remarkably weak."""
        return self.ratio < DOUBTFUL


def reach_of(system: System, derivative: ca.SX, degree: int, rate_per_s: float) -> InputReach | None:
    """Return how u reaches a time derivative of h, or ``None`` where it does not.

    Args:
        system: The plant.
        derivative: Scalar expression of x, u and t.
        degree: Which derivative it is.
        rate_per_s: γ, the rate that the chain itself gives, 1/s.
    """
    gradient = ca.jacobian(derivative, system.u)
    if gradient.nnz() == 0:
        return None
    gradient = ca.simplify(gradient)
    size, here = _first_effects(system, gradient)
    if not here.any():
        return None
    after = _effects(system, ca.jacobian(system.rate(derivative), system.u), size)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(here > 0, (degree + 1) * rate_per_s * here / after, 0.0)
    ratio = float(np.nan_to_num(ratios, nan=inf, posinf=inf).max())
    if ratio < ROUNDING:
        return None
    how = "structure" if not ca.symvar(gradient) else "values"
    return InputReach(degree=degree, how=how, ratio=ratio)


def _first_effects(system: System, gradient: ca.SX) -> tuple[float, Array]:
    """Return the first size of inputs at which there are effects, and these; the first size where there are none."""
    none = _effects(system, gradient, INPUT_SIZES[0])
    if none.any() or not ca.depends_on(gradient, system.u):
        return INPUT_SIZES[0], none
    for size in INPUT_SIZES[1:]:
        effects = _effects(system, gradient, size)
        if effects.any():
            return size, effects
    return INPUT_SIZES[0], none


def _effects(system: System, gradient: ca.SX, size: float) -> Array:
    """Return |∂/∂u| at the probes, shape (P, m): zero where it is rounding, or at no fair share of the probes more."""
    for states in (_general_states(system.n), _positive_states(system.n)):
        found = _steady(np.abs(_gradients(system, gradient, states, size)))
        finite = np.flatnonzero(np.isfinite(found).all(axis=1))
        if finite.size:
            break
    effects = np.zeros(found.shape)
    if finite.size and (found[finite] > 0).any(axis=1).mean() >= FEWEST:
        effects[finite] = found[finite]
    return effects


def _gradients(system: System, gradient: ca.SX, states: Array, size: float) -> Array:
    """Return ∂/∂u at the probes, at each with several changes of its last digits, shape (P, SHIFTS, m).

    A probe is a state at one of two times, with an input of a size.
    """
    x, t_s = np.tile(states, (2, 1)), np.repeat((0.0, 0.71), len(states))
    u = size * np.array([0.53 + 0.17 * j for j in range(system.m)])
    changes = np.random.default_rng(1).uniform(0.5, 1.0, (len(x), SHIFTS, system.n))
    shifted = x[:, None] * (1 + (SHIFT * np.arange(SHIFTS))[:, None] * changes)
    states = shifted.reshape(-1, system.n).T
    evaluate = ca.Function("gradient", [system.x, system.u, system.t], [ca.densify(gradient)])
    values: Array = evaluate(states, np.tile(u[:, None], states.shape[1]), np.repeat(t_s, SHIFTS)[None]).full()
    return values.ravel(order="F").reshape(len(x), SHIFTS, system.m)


def _steady(values: Array) -> Array:
    """Return each probe's gradient without changes, each axis for itself, and zero where it does not stay."""
    with np.errstate(invalid="ignore"):
        spread: Array = values.max(axis=1) - values.min(axis=1)
    without: Array = values[:, 0]
    return np.where(spread <= STEADY * values.max(axis=1), without, np.where(np.isfinite(spread), 0.0, np.nan))


def _general_states(n: int) -> Array:
    """Return states of several sizes in general position, shape (24, n)."""
    return np.array(
        [
            scale * np.array([(0.37 + 0.11 * k + 0.29 * i) * (-1) ** (i + k) for i in range(n)])
            for scale in (1, 10, 100)
            for k in range(8)
        ]
    )


def _positive_states(n: int) -> Array:
    """Return positive states of more sizes, rising and falling, for what is not defined elsewhere; shape (24, n)."""
    rising = [np.array([0.37 + 0.11 * k + 0.29 * i for i in range(n)]) for k in range(2)]
    return np.array([scale * one for scale in SIZES for each in rising for one in (each, each[::-1])])
