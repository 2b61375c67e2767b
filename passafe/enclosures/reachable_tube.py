"""The tube of states around x that no trajectory leaves while an input is held (``docs/theory.md``, section 6).

Let x(τ) follow ẋ = f(x, u) under a constant u and e = x(τ) − x(0). With J = ∂f/∂x, f(x + e, u) = f(x, u) + J̄e for a
mean J̄ of J over the tube, so |e| ≤ z componentwise wherever ż = |f(x, u)| + Mz, z(0) = 0, with a matrix M whose
diagonal bounds J's from above and whose other entries bound |J|'s (comparison of Metzler systems; Walter 1998, chapter
III).
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import casadi as ca
import numpy as np

from passafe.enclosures.angle_cuts import apart_from_cuts
from passafe.enclosures.enclosure import enclose
from passafe.numerics.fixed_order import exponential, product
from passafe.numerics.workspace import Array
from passafe.system import System

PIECES: Final = 64
"""Number of intervals in which ∫|e^{As}|ds is bounded."""

GROWTH: Final = 2.0
"""Factor by which the first guess of a nonlinear plant's tube is wider than what J at x alone gives."""

GUESSES: Final = 2
"""How often a nonlinear plant's tube is guessed: a first guess is too narrow for a state that rests at x but not in the
tube, as the height of a quadrotor that is level, or a car's sideways place while it heads along an axis."""

SPARE: Final = 1.1
"""Factor by which every refinement of the tube exceeds what it was found to need."""


SMALL: Final = 1e-4
"""|a|T below which (e^{aT} − 1)/a is bounded by a series."""


class Tube(NamedTuple):
    """Bound of the distance from x while an input is held.

    Attributes:
        radius: Of every state, expression of x and u, shape (n, 1).
        known: 1 where the bound is proven, else 0, expression.
    """

    radius: ca.SX
    known: ca.SX


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class HeldMotion:
    """Dynamics ẋ = f with all that is not known of them while an input is held.

    Attributes:
        f: Expression of x and the symbols that stay, shape (n, 1).
        x: State symbol, shape (n, 1).
        x_radius: By how much each state may differ from x at the beginning, expression, shape (n, 1).
        held: Symbols that stay, at values that are not known exactly, shape (k, 1).
        held_radius: By how much each of those may differ from its present value, expression, shape (k, 1).
        constants: Those of ``held`` whose present value is always the same.
        values: These values, as many.
        push: Bound of what acts on each state's rate besides f, shape (n, 1).
    """

    f: ca.SX
    x: ca.SX
    x_radius: ca.SX
    held: ca.SX
    held_radius: ca.SX
    constants: ca.SX
    values: tuple[float, ...]
    push: ca.DM

    @classmethod
    def of(cls, system: System, input_radius: ca.SX) -> "HeldMotion":
        """Return the motion of a plant as modelled, under any held input within a radius of u."""
        return cls(
            f=system.f,
            x=system.x,
            x_radius=ca.SX.zeros(system.n),
            held=system.u,
            held_radius=input_radius,
            constants=ca.SX(0, 1),
            values=(),
            push=ca.DM.zeros(system.n),
        )

    @property
    def n(self) -> int:
        """Number of states."""
        return int(self.x.numel())

    @property
    def speed(self) -> Tube:
        """Bound of |ẋ| at the beginning, as the radius of a ``Tube``."""
        f = enclose(self.f, ca.vertcat(self.x, self.held), ca.vertcat(self.x_radius, self.held_radius))
        return Tube(ca.fabs(f.centre) + f.radius + self.push, f.known)


def reachable_tube(system: System, held_s: float, input_radius: ca.SX, *, guesses: int = GUESSES) -> Tube:
    """Return the tube around x within ``held_s`` seconds under any held input near u.

    Where J is constant the bound is (∫₀ᵀ|e^{Js}|ds)·|f|, for any T. Otherwise M is enclosed over a guessed tube, and
    the bound is known where it is no wider than the guess.

    Args:
        system: The plant.
        held_s: T, how long the input is held at most, s.
        input_radius: By how much each axis of the held input may differ from u, expression, shape (m, 1).
        guesses: How often a nonlinear plant's tube is guessed anew from the one before.

    Raises:
        DesignError: The dynamics have an operation without an enclosure.
    """
    return tube_of(HeldMotion.of(system, input_radius), held_s, guesses=guesses)


def tube_of(motion: HeldMotion, held_s: float, *, guesses: int = GUESSES) -> Tube:
    """Return the tube of a motion around where it begins, as ``reachable_tube`` does.

    Where J depends on constants alone, M is a matrix of numbers, and the bound is (∫₀ᵀe^{Ms}ds)·sup|f|.

    Args:
        motion: Dynamics and what is not known of them.
        held_s: T, how long the input is held at most, s.
        guesses: See ``reachable_tube``.
    """
    speed, speed_known = motion.speed
    J = ca.simplify(ca.jacobian(motion.f, motion.x))
    if not ca.symvar(J):
        A = ca.DM(ca.densify(J)).full()
        return Tube(ca.DM(integral_of_magnitude(A, held_s)) @ speed, speed_known)
    M = metzler_bound(motion)
    if M is not None:
        return Tube(ca.DM(integral_of_exponential(M, held_s)) @ speed, speed_known)
    J = ca.jacobian(motion.f, motion.x)
    near = comparison_matrix(motion, J, ca.SX.zeros(motion.n))
    guess = GROWTH * _refined(near.radius, speed, held_s)
    over = comparison_matrix(motion, J, guess)
    for _ in range(guesses - 1):
        guess = GROWTH * _refined(over.radius, speed, held_s)
        over = comparison_matrix(motion, J, guess)
    radius = _refined(over.radius, speed, held_s)
    fits = ca.logic_and(
        ca.mmax(radius - guess) <= 0, ca.mmax(_reached(over.radius, radius, speed, held_s) - radius) <= 0
    )
    box = ca.vertcat(motion.x_radius + radius, motion.held_radius)
    apart = apart_from_cuts(motion.f, ca.vertcat(motion.x, motion.held), box)
    return Tube(radius, ca.if_else(fits, speed_known * over.known * apart, 0))


def metzler_bound(motion: HeldMotion) -> Array | None:
    """Return M, shape (n, n), where ∂f/∂x depends on constants alone, else ``None``.

    Its diagonal bounds that of ∂f/∂x from above for every value of the constants, its other entries the magnitudes.
    """
    J = ca.simplify(ca.jacobian(motion.f, motion.x))
    known = {symbol.element_hash() for symbol in ca.vertsplit(motion.constants)}
    if any(symbol.element_hash() not in known for symbol in ca.symvar(J)):
        return None
    M = comparison_matrix(motion, J, ca.SX.zeros(motion.n))
    at_values = ca.substitute([M.radius], [motion.constants], [ca.SX(ca.DM(list(motion.values)))])[0]
    return np.asarray(ca.DM(ca.densify(at_values)).full())


def integral_of_exponential(M: Array, held_s: float) -> Array:
    """Return ∫₀ᵀe^{Ms}ds, shape (n, n)."""
    n = len(M)
    block = np.zeros((2 * n, 2 * n))
    block[:n, :n], block[:n, n:] = M, np.eye(n)
    return exponential(block * held_s)[:n, n:]


def integral_of_magnitude(A: Array, held_s: float) -> Array:
    """Return a matrix that is no less than ∫₀ᵀ|e^{As}|ds anywhere: |e^{A(s+σ)}| ≤ |e^{As}|e^{Mσ} on every piece."""
    n, piece_s = len(A), held_s / PIECES
    M = np.abs(A)
    np.fill_diagonal(M, np.maximum(np.diag(A), 0.0))
    within = integral_of_exponential(M, piece_s)
    step, reached, total = exponential(A * piece_s), np.eye(n), np.zeros((n, n))
    for _ in range(PIECES):
        total += np.abs(reached)
        reached = product(step, reached)
    return product(total, within)


def comparison_matrix(motion: HeldMotion, J: ca.SX, radius: ca.SX) -> Tube:
    """Return M as the radius of a ``Tube`` of matrices, shape (n, n); ``radius`` is that of the tube."""
    symbols, radii = ca.vertcat(motion.x, motion.held), ca.vertcat(motion.x_radius + radius, motion.held_radius)
    ball = enclose(ca.vec(ca.densify(J)), symbols, radii)
    n = motion.n
    M = ca.reshape(ca.fabs(ball.centre) + ball.radius, n, n)
    signed = ca.reshape(ball.centre + ball.radius, n, n)
    for i in range(n):
        M[i, i] = signed[i, i]
    return Tube(ca.sparsify(M), ball.known)


def _refined(M: ca.SX, speed: ca.SX, held_s: float) -> ca.SX:
    """Return what is reached after as many rounds as a chain of n integrators needs."""
    radius = ca.SX.zeros(speed.numel())
    for _ in range(speed.numel() + 1):
        radius = SPARE * _reached(M, radius, speed, held_s)
    return radius


def _reached(M: ca.SX, radius: ca.SX, speed: ca.SX, held_s: float) -> ca.SX:
    """Return (e^{M_ii T} − 1)/M_ii · (|f_i| + Σ_{j≠i} M_ij R_j) for every state."""
    n = speed.numel()
    return ca.vertcat(
        *(
            _growth(M[i, i], held_s)
            * (speed[i] + sum((M[i, j] * radius[j] for j in range(n) if j != i and M.has_nz(i, j)), ca.SX(0)))
            for i in range(n)
        )
    )


def _growth(rate: ca.SX, held_s: float) -> ca.SX:
    """Return (e^{aT} − 1)/a, no less than it where a is near zero."""
    if rate.is_zero():
        return ca.SX(held_s)
    small = ca.fabs(rate) * held_s < SMALL
    series = held_s * (1 + ca.fabs(rate) * held_s)
    return ca.if_else(small, series, ca.expm1(rate * held_s) / ca.if_else(small, 1, rate))
