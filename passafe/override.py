"""What the filter changed in one decision, by which rows, and how much of the command would have passed unchanged.

Asked for is u_want = u + dt·φ, or û where there was no input before. The decision is

    u⁺ − u_want = Σᵢ λᵢ gᵢ,

the multipliers' stationarity: every row that binds pushes by λᵢ along its gradient of unit length, and a limit of an
axis pushes by what it cuts off u_want, too. u_want moves with the operator's part by k = dt·k_i (1 at the start), so
(u⁺ − u_want)/k is by how much the command would have had to differ for the same input to pass without any change.
"""

import struct
from dataclasses import dataclass
from math import inf
from typing import Final

import casadi as ca
import numpy as np

from passafe.decision import Decision, Status
from passafe.filter import SafetyPassivityFilter
from passafe.workspace import Array, BlockLayout, Workspace, dense_function

ACTIVE_DUAL: Final = 1e-6
"""Push from which a row counts as active, units of u."""


@dataclass(frozen=True, kw_only=True, slots=True)
class OverrideCause:
    """A row that pushed.

    Attributes:
        row: Its name.
        push: λ, units of u; for a limit of an axis with what it cut off what was asked for.
        share: Share of the change, λ gᵀ(u⁺ − u_want)/‖u⁺ − u_want‖². The shares of all rows sum to 1; one is negative
            where the others push against it.
    """

    row: str
    push: float
    share: float


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Override:
    """What became of a request.

    Attributes:
        change: u⁺ − u_want, shape (m,), units of u.
        held_back: The same in terms of the operator's command, (u⁺ − u_want)/k, shape (m,), units of u. Where the
            input has settled it is u⁺ − û.
        causes: Active rows, the one with the largest share first; none under the fail-safe law.
        allowed_fraction: Largest s in [0, 1] for which the command s·(u_h, u̇_h) would have passed without a change: no
            row relaxed, no slack, no limit in the way. 0 where no s would have.
        unavoidable: Whether no s in [0, 1] would have.
    """

    change: Array
    held_back: Array
    causes: tuple[OverrideCause, ...]
    allowed_fraction: float
    unavoidable: bool

    @property
    def size(self) -> float:
        """‖held_back‖, units of u."""
        return float(np.linalg.norm(self.held_back))


class Explainer:
    """Explains the decisions of one filter.

    Rows count as they are in the decision: with its tangents, where they are not affine in u, and with its margins
    between samples, which are made for inputs near u⁺. They are kept where they are missed by no more than the
    certificate tolerates.

    What it computes is one CasADi function: dozens of calls for a few numbers each would take longer than the decision.
    """

    def __init__(self, core: SafetyPassivityFilter) -> None:
        """Take from the filter what does not change."""
        self._names = core.row_names
        parts = core.layout.parts
        sizes = {name: place.stop - place.start for name, place in parts.items()}
        symbols = {name: ca.SX.sym(name, size) for name, size in sizes.items()}
        explained = _explained(core, symbols)
        read = [name for name in sizes if ca.depends_on(ca.vertcat(*explained.values()), symbols[name])]
        function = dense_function("explain", [symbols[name] for name in read], list(explained.values()))
        own = {name: value.numel() for name, value in explained.items()}
        self._space = space = Workspace(BlockLayout.of(sizes | own))
        self._evaluate = space.bind(function, read, list(own))
        self._decided = space.block[: core.layout.size]
        self._change, self._held_back = space.part("change"), space.part("held_back")
        at = space.layout.parts
        self._give = struct.Struct(f"{2 * len(self._names) + 1}d").unpack_from, at["push"].start * 8

    def override(self, decision: Decision) -> Override:
        """Return what became of the decision's request."""
        self._decided[:] = decision.block
        self._evaluate()
        give, at = self._give
        *pushes_and_shares, fraction = give(self._space.memory, at)
        change = self._change.copy()
        if decision.status is Status.PASSED and not change.any():
            return Override(change=change, held_back=change, causes=(), allowed_fraction=1.0, unavoidable=False)
        return Override(
            change=change,
            held_back=self._held_back.copy(),
            causes=self._causes(pushes_and_shares),
            allowed_fraction=max(fraction, 0.0),
            unavoidable=fraction < 0.0,
        )

    def _causes(self, pushes_and_shares: list[float]) -> tuple[OverrideCause, ...]:
        """Return the active rows in the order of their shares."""
        count = len(self._names)
        rows = zip(self._names, pushes_and_shares[:count], pushes_and_shares[count:], strict=True)
        causes = [OverrideCause(row=name, push=push, share=share) for name, push, share in rows if push > ACTIVE_DUAL]
        return tuple(sorted(causes, key=lambda cause: -cause.share))


def _explained(core: SafetyPassivityFilter, parts: dict[str, ca.SX]) -> dict[str, ca.SX]:
    """Return what is computed of a decision's parts: the last is the allowed fraction, −1 where there is none."""
    design = core.design
    m, dt_s = design.system.m, design.dt_s
    start, u_h = parts["start"], parts["u_h"]
    wanted = ca.if_else(start, parts["u_nominal"], parts["u"] + dt_s * parts["phi"])
    gain = ca.if_else(start, 1.0, dt_s * design.k_i)
    command = ca.if_else(start, u_h, gain * u_h + dt_s * parts["u_h_rate"])
    change = parts["u_plus"] - wanted
    G = ca.reshape(parts["G"], core.duties, core.derivation.k)[:, :m]
    cuts = ca.reshape(parts["cuts"], len(core.row_names) - core.duties - 2 * m, m)
    cut_off = parts["u_ref"] - wanted
    axes = ca.fmax(ca.vertcat(cut_off, -cut_off), 0)
    push = parts["lam"] + ca.vertcat(ca.SX(core.duties, 1), axes, ca.SX(cuts.shape[0], 1))
    along = ca.vertcat(G @ change, change, -change, -cuts @ change)
    square = ca.sumsqr(change)
    kept = ca.vertcat(G @ (wanted - parts["u_ref"]) - parts["d"], wanted - parts["low"], parts["high"] - wanted)
    least, most = _interval(kept + design.tolerance.residual, ca.vertcat(G @ command, command, -command))
    if design.limits.norm is not None:
        at_least, at_most = _within(wanted, command, design.limits.norm + design.tolerance.residual)
        least, most = ca.fmax(least, at_least), ca.fmin(most, at_most)
    is_number = ca.sumsqr(wanted) + ca.sumsqr(command) < inf
    return {
        "change": change,
        "held_back": change / gain,
        "push": push,
        "share": ca.if_else(square > 0, push * along / square, 0),
        "allowed_fraction": ca.if_else(ca.logic_and(is_number, least <= ca.fmin(most, 1)), 1 - least, -1),
    }


def _interval(kept: ca.SX, slope: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the least and the largest q ≥ 0 with kept − q·slope ≥ 0 in every place; the least is inf without one."""
    ends = kept / slope
    rises = ca.logic_and(kept < 0, slope < 0)
    never = ca.logic_not(ca.logic_or(slope > 0, ca.logic_or(rises, kept >= 0)))
    least = ca.if_else(never, inf, ca.if_else(rises, ends, 0))
    return ca.mmax(ca.vertcat(0, least)), ca.mmin(ca.vertcat(inf, ca.if_else(slope > 0, ends, inf)))


def _within(wanted: ca.SX, command: ca.SX, norm: float) -> tuple[ca.SX, ca.SX]:
    """Return the least and the largest q with ‖wanted − q·command‖ ≤ norm; inf and −inf without one."""
    a, b, c = ca.sumsqr(command), ca.dot(command, wanted), ca.sumsqr(wanted) - norm**2
    under = b * b - a * c
    root = ca.sqrt(ca.fmax(under, 0))
    some, always = ca.logic_and(a > 0, under >= 0), ca.logic_and(a == 0, c <= 0)
    return (
        ca.if_else(always, -inf, ca.if_else(some, (b - root) / a, inf)),
        ca.if_else(always, inf, ca.if_else(some, (b + root) / a, -inf)),
    )
