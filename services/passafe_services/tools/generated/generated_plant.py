"""A random plant with the quantities that a design is drawn from."""

from dataclasses import dataclass

import casadi as ca

from passafe.system import System


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class BarrierOffer:
    """A safe set that suits a plant.

    Attributes:
        name: Its name.
        h: Expression of the plant's x, and of its t where the set moves.
        degree: Relative degree, known from how the plant was built.
    """

    name: str
    h: ca.SX
    degree: int


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class GeneratedPlant:
    """A plant, its laws, its safe sets, and the states in which it is looked at.

    Attributes:
        system: The dynamics.
        storage: V(x), J: with it ``system.y`` is a port through which energy goes in, except where springs are added.
        fail_safe: Law that brings the plant to rest where it can be, shape (m, 1).
        feedback: u_fb, shape (m, 1).
        barriers: Safe sets, at least one.
        low: Lowest corner of the box of states, n numbers.
        high: Highest one.
        input_scale: Inputs that move this plant noticeably, m numbers.
        natural_rate_per_s: Rate at which an operator would excite it, 1/s.
        largest_input: Inputs beyond which the model means nothing, m numbers; ``None`` without such a limit.
    """

    system: System
    storage: ca.SX
    fail_safe: ca.SX
    feedback: ca.SX
    barriers: tuple[BarrierOffer, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    input_scale: tuple[float, ...]
    natural_rate_per_s: float
    largest_input: tuple[float, ...] | None = None

    @property
    def is_affine(self) -> bool:
        """True if f is affine in u."""
        slope = ca.simplify(ca.jacobian(self.system.f, self.system.u))
        return not ca.depends_on(slope, self.system.u)


def symmetric(*half_widths: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the lowest and the highest corner of a box around the origin."""
    return tuple(-width for width in half_widths), tuple(half_widths)
