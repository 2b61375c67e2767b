"""Checks of a design before anything moves: what holds by its formulas alone, and what its start and its rates say."""

from collections.abc import Sequence
from typing import Final

import casadi as ca
import numpy as np

from passafe.barrier_chain import BarrierChain
from passafe.checks.row_share import StateBox, row_findings
from passafe.checks.undefined_slope import undefined_at
from passafe.design import FilterDesign
from passafe.errors import ShapeError
from passafe.expressions.expression_graph import graph_of
from passafe.expressions.storage_sign import descent_of
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity
from passafe.numerics.workspace import Array

NOTE, WARNING = Severity.NOTE, Severity.WARNING

STIFFEST: Final = 50.0
"""Longest hold times stiffness that the margins between samples are tried for."""

STEEPEST: Final = 1.0
"""Gain times hold above which ψ may be used up within one hold."""

PROBES: Final = 64
"""States at which the slope of f is looked at."""


def formula_findings(
    design: FilterDesign, chains: Sequence[BarrierChain], x0: Sequence[float] | None = None, t_s: float = 0.0
) -> tuple[Finding, ...]:
    """Return what the formulas of a design show, without a decision.

    Args:
        design: The design.
        chains: The chains of its barriers.
        x0: State at the start, n numbers, if it is known.
        t_s: Plant time at the start, s.
    """
    degrees = (_degree(chain) for chain in chains)
    start = () if x0 is None else (_start(design, chain, x0, t_s) for chain in chains)
    undefined = () if x0 is None else undefined_at(design, chains, x0, t_s)
    steep = (finding for chain in chains if (finding := _steepness(design, chain)) is not None)
    angles = (finding for chain in chains if (finding := _angles(chain)) is not None)
    return (*degrees, *start, *undefined, *angles, *steep, _storage(design), _stiffness(design, x0))


def check_design(
    core: SafetyPassivityFilter, box: StateBox, *, samples: int = 400, seed: int = 1
) -> tuple[Finding, ...]:
    """Return all findings of a filter before it is used: those of its formulas, and those that take decisions.

    Args:
        core: The filter.
        box: Its start, and the box that random states are drawn from.
        samples: Number of random states.
        seed: Seed of both.

    Raises:
        ShapeError: The box has another number of coordinates than the plant.
    """
    if len(box.x0) != core.design.system.n:
        raise ShapeError("state box", f"{len(box.x0)} numbers", f"{core.design.system.n}: one for each state")
    return (*formula_findings(core.design, core.chains, box.x0), *row_findings(core, box, samples, seed))


def _degree(chain: BarrierChain) -> Finding:
    reach = chain.reach
    found = (
        f"{chain.relative_degree}: the input appears in derivative {chain.relative_degree} of h, found by {reach.how}"
    )
    if not reach.is_doubtful:
        return Finding(severity=NOTE, topic="relative degree", subject=_name(chain), found=found)
    return Finding(
        severity=WARNING,
        topic="relative degree",
        subject=_name(chain),
        found=f"{found}, but {reach.ratio:.2g} times as strongly as in the next one within 1/γ",
        advice="leave so weak a path out of the dynamics: rows that rest on it ask for inputs out of all proportion",
    )


def _start(design: FilterDesign, chain: BarrierChain, x0: Sequence[float], t_s: float) -> Finding:
    psi = ca.Function("psi", [design.system.x, design.system.t], [ca.densify(ca.vertcat(*chain.psi[:-1]))])
    values = psi(ca.DM(list(x0)), t_s).full().ravel()
    least = int(np.argmin(values))
    found = ", ".join(f"ψ{_subscript(k)} = {value:.4g}" for k, value in enumerate(values))
    if values[least] >= 0:
        return Finding(severity=NOTE, topic="start", subject=_name(chain), found=found)
    what = "h < 0" if values[0] < 0 else f"ψ{_subscript(least)} < 0"
    return Finding(
        severity=WARNING,
        topic="start",
        subject=_name(chain),
        found=f"{found}: {what}, outside the set that the rows protect",
        advice="start slower or further away, or raise the gain of the function before it: h may become negative",
    )


def _angles(chain: BarrierChain) -> Finding | None:
    h = chain.psi[0]
    angle = next((each for each in graph_of(h).operations if each.number == ca.OP_ATAN2), None)
    if angle is None:
        return None
    return Finding(
        severity=NOTE,
        topic="angle",
        subject=_name(chain),
        found=f"{angle.text} jumps by a full turn at its cut, near which no margin is known",
        advice="keep the cut out of the set, or write a cross product, such as x·sin(a) − y·cos(a), for the angle",
    )


def _steepness(design: FilterDesign, chain: BarrierChain) -> Finding | None:
    gain = max(gamma.gain for gamma in chain.barrier.class_k[: chain.relative_degree])
    product = gain * design.held_s
    if product <= STEEPEST:
        return None
    return Finding(
        severity=NOTE,
        topic="loop rate",
        subject=_name(chain),
        found=f"gain {gain:g}/s times the longest hold {design.held_s:g} s is {product:.3g}",
        advice="below 1 the margins between samples are small; a higher rate, a shorter hold or a lower gain",
    )


def _storage(design: FilterDesign) -> Finding:
    descent = descent_of(design.passivity.V, design.system.x)
    if descent is None:
        found = "no direction in which V falls without end"
        return Finding(severity=NOTE, topic="storage", subject="V", found=found)
    return Finding(
        severity=WARNING,
        topic="storage",
        subject="V",
        found=f"not bounded from below: {descent}",
        advice="a V ≥ 0: from any other, energy without end may be drawn and the passivity row means nothing",
    )


def _stiffness(design: FilterDesign, x0: Sequence[float] | None) -> Finding:
    system = design.system
    slope = ca.Function("slope", [system.x, system.u], [ca.densify(ca.jacobian(system.f, system.x))])
    rng = np.random.default_rng(1)
    about: Array = np.zeros(system.n) if x0 is None else np.asarray(x0, dtype=float)
    centre = ca.DM(list(design.limits.centre))
    states = [about, *(about + rng.normal(size=(PROBES, system.n)))]
    slopes = (slope(x, centre).full() for x in states)
    rate = max((float(np.abs(np.linalg.eigvals(A)).max()) for A in slopes if np.isfinite(A).all()), default=0.0)
    product = rate * design.held_s
    found = f"fastest rate {rate:.3g}/s times the longest hold {design.held_s:g} s is {product:.3g}"
    if product <= STIFFEST:
        return Finding(severity=NOTE, topic="stiffness", subject="dynamics", found=found)
    return Finding(
        severity=WARNING,
        topic="stiffness",
        subject="dynamics",
        found=found,
        advice=f"at most {STIFFEST:g} is tried: a higher rate, a shorter hold, or a model without so fast a part",
    )


def _name(chain: BarrierChain) -> str:
    return f"barrier {chain.barrier.name!r}"


def _subscript(k: int) -> str:
    return str(k).translate(str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉"))
