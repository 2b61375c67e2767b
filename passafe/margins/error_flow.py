"""The growth of a state's error over one period, as an expression (``docs/theory.md``, section 13).

Let x̂ follow the model and x a member of the family, both under the input that is sent, and e = x − x̂. With d the most
that parameters, input error and disturbance change of ẋ along x̂, and J̄ a mean of ∂f/∂x,

    ė = J̄e + d̄,  |d̄| ≤ d,   so   |e(T)| ≤ e^{MT}|e(0)| + ∫₀ᵀe^{Ms}ds·d,

where M's diagonal bounds that of ∂f/∂x from above, and its other entries the magnitudes, for every member and wherever
x can be. Where ∂f/∂x is constant |e^{AT}| and ∫|e^{As}|ds stand for these, which are less. d is that of the input in
force, not of the largest one.
"""

from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.enclosures.angle_cuts import apart_from_cuts
from passafe.enclosures.enclosure import enclose
from passafe.enclosures.reachable_tube import (
    HeldMotion,
    comparison_matrix,
    integral_of_exponential,
    integral_of_magnitude,
    metzler_bound,
    reachable_tube,
)
from passafe.margins.plant_family import PlantFamily
from passafe.numerics.fixed_order import exponential
from passafe.sampled_plant import LOCAL_TOLERANCE, is_linear
from passafe.system import System

TERMS: Final = 5
"""Terms of an exponential's series; what is left out is bounded."""

ROOM: Final = 2.0
"""Factor by which the guess of an error within a period exceeds what the slopes along x̂ give."""


class ErrorFlow(NamedTuple):
    """Bound of the error one period later, expressions of x̂, u and the error before.

    Attributes:
        radius: Of every state, shape (n, 1).
        known: 1 where it is proven, else 0.
    """

    radius: ca.SX
    known: ca.SX


def error_flow(nominal: System, family: PlantFamily, radius: ca.SX, dt_s: float) -> ErrorFlow:
    """Return the error one period later.

    Args:
        nominal: The model that x̂ follows.
        family: The plants of which x is one.
        radius: Error at the beginning, symbol, shape (n, 1).
        dt_s: Period, s.

    Raises:
        DesignError: The dynamics have an operation without an enclosure.
    """
    n, no_input = nominal.n, ca.SX.zeros(nominal.m)
    along = reachable_tube(nominal, dt_s, no_input)
    push, push_known = _push(nominal, family, along.radius)
    motion = family.motion(along.radius, no_input)
    J = ca.simplify(ca.jacobian(motion.f, motion.x))
    M = metzler_bound(motion)
    if not ca.symvar(J):
        A = ca.DM(ca.densify(J)).full()
        after = ca.DM(np.abs(exponential(A * dt_s))) @ radius + ca.DM(integral_of_magnitude(A, dt_s)) @ push
        known = ca.SX(1)
    elif M is not None:
        after = ca.DM(exponential(M * dt_s)) @ radius + ca.DM(integral_of_exponential(M, dt_s)) @ push
        known = ca.SX(1)
    else:
        after, known = _nonlinear(motion, radius, push, dt_s)
    if not is_linear(nominal):
        after += LOCAL_TOLERANCE * ca.SX.ones(n)  # of the model's own steps
    known = known * along.known * push_known
    return ErrorFlow(*ca.substitute([after, known], [family.symbols], [family.centres]))


def _push(nominal: System, family: PlantFamily, along: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return d, shape (n, 1), and whether it is known."""
    system = family.system
    values = {each.name: each.value for each in nominal.parameters}
    far = [each.distance(values[each.name]) for each in family.coordinates]
    moved = ca.vertcat(system.u, family.symbols)
    effect = ca.vec(ca.densify(ca.jacobian(system.general_f, moved)))
    box = ca.vertcat(along, family.input_error, family.radii)
    ball = enclose(effect, ca.vertcat(system.x, moved), box)
    most = ca.reshape(ca.fabs(ball.centre) + ball.radius, system.n, moved.numel())
    return most @ ca.vertcat(ca.SX(family.input_error), ca.SX(ca.DM(far))) + family.disturbance, ball.known


def _nonlinear(motion: HeldMotion, radius: ca.SX, push: ca.SX, dt_s: float) -> tuple[ca.SX, ca.SX]:
    """Return the error where M depends on the state: it is enclosed over a guess, and known if that is wide enough."""
    J = ca.jacobian(motion.f, motion.x)
    near = comparison_matrix(motion, J, ca.SX.zeros(motion.n))
    guess = ROOM * _exponential(ca.fmax(near.radius, 0) * dt_s, radius + dt_s * push)
    over = comparison_matrix(motion, J, guess)
    after = _exponential(over.radius * dt_s, radius) + dt_s * _exponential(ca.fmax(over.radius, 0) * dt_s, push)
    within = _exponential(ca.fmax(over.radius, 0) * dt_s, radius + dt_s * push)
    box = ca.vertcat(motion.x_radius + guess, motion.held_radius)
    apart = apart_from_cuts(motion.f, ca.vertcat(motion.x, motion.held), box)
    return after, over.known * apart * (ca.mmax(within - guess) <= 0)


def _exponential(N: ca.SX, v: ca.SX) -> ca.SX:
    """Return a bound of e^N v for a Metzler N and v ≥ 0: e^{−c}e^{N + cI}v, the series' tail in the largest norm."""
    n = int(v.numel())
    least = ca.mmin(ca.vertcat(0, *(N[i, i] for i in range(n))))
    N = ca.densify(N) - least * ca.SX.eye(n)
    total, term = v, v
    for k in range(1, TERMS + 1):
        term = N @ term / k
        total += term
    size = ca.norm_inf(N)
    tail = ca.norm_inf(v) * size ** (TERMS + 1) * ca.exp(size) / ca.SX(float(np.prod(np.arange(1.0, TERMS + 2))))
    return ca.exp(least) * (total + tail)
