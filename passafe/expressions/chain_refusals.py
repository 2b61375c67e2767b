"""Refusals of a barrier's chain once it is derived."""

from collections.abc import Sequence

import casadi as ca

from passafe.errors import DesignError
from passafe.expressions.input_reach import InputReach
from passafe.expressions.slopes import broken_at


def other_number(part: str, got: int, wanted: int) -> DesignError:
    """Return the refusal of a number of class-K functions that does not follow from the relative degree."""
    allowed = f"{wanted}: relative degree {wanted - 1} and one more"
    return DesignError(f"{part} class_k", f"{got} functions", allowed)


def require_one_degree(part: str, degrees: Sequence[int]) -> None:
    """Refuse a maximum whose branches have different relative degrees: no chain is that of both."""
    if len(set(degrees)) > 1:
        allowed = "branches of one relative degree: p + v/γ ≥ 0 in the place of v ≥ 0 beside a place, for example"
        raise DesignError(f"{part} h", f"a maximum of branches of relative degrees {list(degrees)}", allowed)


def require_effect(part: str, reach: InputReach) -> None:
    """Refuse a relative degree that rests on an effect which the next derivative outweighs by orders of magnitude."""
    if reach.is_too_weak:
        raise DesignError(
            part,
            f"an input that reaches derivative {reach.degree} of h {reach.ratio:.2g} times as strongly as the next "
            f"one within 1/γ: a relative degree of {reach.degree} by formula, of {reach.degree + 1} or more in effect",
            "dynamics without so weak a path (leave the term out, and bound it as a disturbance), or one that counts",
        )


def require_slope(part: str, derivative: ca.SX, order: int) -> None:
    """Refuse a time derivative of h at whose kink a held input would bend the chain without bound."""
    broken = broken_at(derivative) if order else None
    if broken is not None:
        raise DesignError(
            part,
            f"{broken.text} of the dynamics in derivative {order} of h, which has no slope there",
            "a slope before u appears; write tanh for a saturation, sqrt(v**2 + 0.01) for fabs(v)",
        )
