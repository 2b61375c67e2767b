"""Operators of generated loops: adversaries at the boundary, switches, sinusoids at resonance, and smooth ones."""

from collections.abc import Callable, Mapping
from typing import Final, TypeAlias

import casadi as ca
import numpy as np

from passafe.numerics.workspace import Array
from passafe_services.tools.generated.generated_design import GeneratedDesign
from passafe_services.tools.generated.random_numbers import log_uniform

Command: TypeAlias = tuple[Array, Array]
"""u_h and its time derivative, each of shape (m,)."""

Operator: TypeAlias = Callable[[int, Array], Command]
"""From the tick and the state to a command."""


def at_the_boundary(rng: np.random.Generator, design: GeneratedDesign) -> Operator:
    """Push with full strength at whatever barrier has the least ψ_{r−1}."""
    towards, strength = _direction(design), np.array(design.limits.magnitude) * log_uniform(rng, 0.2, 1.0)
    return lambda k, x: (strength * towards(k, x), np.zeros_like(strength))


def push_and_release(rng: np.random.Generator, design: GeneratedDesign) -> Operator:
    """Push at the boundary and away from it in turn, with one to twenty periods each."""
    towards, strength = _direction(design), np.array(design.limits.magnitude)
    periods = int(np.ceil(log_uniform(rng, 0.5, 20.0)))
    return lambda k, x: (strength * towards(k, x) * (1 - 2 * (k // periods % 2)), np.zeros_like(strength))


def switch(rng: np.random.Generator, design: GeneratedDesign) -> Operator:
    """Switch between two opposite inputs, up to the limit, as fast as every period: half the tick rate."""
    bound = np.array(design.limits.magnitude)
    amplitude = bound * rng.choice([-1.0, 1.0], len(bound)) * log_uniform(rng, 0.1, 1.0)
    periods = int(np.ceil(log_uniform(rng, 0.5, 10.0)))
    return lambda k, _: (amplitude * (1 - 2 * (k // periods % 2)), np.zeros_like(amplitude))


def at_random(rng: np.random.Generator, design: GeneratedDesign) -> Operator:
    """Ask for something else now and then, anywhere within the limits."""
    bound = np.array(design.limits.magnitude)
    stay, asked = rng.uniform(0.0, 0.98), np.zeros_like(bound)

    def ask(_k: int, _x: Array) -> Command:
        if rng.random() > stay:
            asked[:] = rng.uniform(-bound, bound)
        return asked.copy(), np.zeros_like(bound)

    return ask


def sinusoid(rng: np.random.Generator, design: GeneratedDesign) -> Operator:
    """Swing near the plant's own rate, with its true derivative."""
    bound, dt_s = np.array(design.limits.magnitude), design.timing.dt_s
    amplitude = bound * rng.uniform(0.1, 1.0, len(bound))
    rate = min(design.plant.natural_rate_per_s * log_uniform(rng, 0.5, 2.0), np.pi / dt_s)
    phase = rng.uniform(0, 2 * np.pi, len(bound))

    def ask(k: int, _x: Array) -> Command:
        angle = rate * k * dt_s + phase
        return amplitude * np.sin(angle), amplitude * rate * np.cos(angle)

    return ask


def smooth(rng: np.random.Generator, design: GeneratedDesign) -> Operator:
    """Drift from one wish to the next by a first-order lag, with its true derivative."""
    bound, dt_s = np.array(design.limits.magnitude), design.timing.dt_s
    lag_s = dt_s * log_uniform(rng, 3.0, 50.0)
    asked, wish = np.zeros_like(bound), rng.uniform(-bound, bound)

    def ask(_k: int, _x: Array) -> Command:
        if rng.random() < dt_s / lag_s / 2:
            wish[:] = rng.uniform(-bound, bound)
        asked[:] = wish + (asked - wish) * np.exp(-dt_s / lag_s)
        return asked.copy(), (wish - asked) / lag_s

    return ask


OPERATORS: Final[Mapping[str, Callable[[np.random.Generator, GeneratedDesign], Operator]]] = {
    "boundary": at_the_boundary,
    "push-and-release": push_and_release,
    "switch": switch,
    "random": at_random,
    "sinusoid": sinusoid,
    "smooth": smooth,
}
"""By name; loops draw one of them."""


def _direction(design: GeneratedDesign) -> Callable[[int, Array], Array]:
    """Return the direction, of unit length in the maximum norm, that lowers the nearest barrier's ψ_r fastest."""
    system, scale = design.plant.system, np.array(design.plant.input_scale)
    nearest = ca.vertcat(*(chain.psi[-2] for chain in design.chains))
    slopes = ca.vertcat(*(ca.jacobian(chain.psi[-1], system.u) for chain in design.chains))
    evaluate = ca.Function("push", [system.x, system.u, system.t], [nearest, ca.densify(slopes)])

    def direction(k: int, x: Array) -> Array:
        values, gradients = evaluate(x, scale / 7, k * design.timing.dt_s)
        pull = -gradients.full()[int(values.full().argmin())] * scale
        size = np.abs(pull).max()
        return np.asarray(pull / size) if 0 < size < np.inf else np.ones_like(scale)

    return direction
