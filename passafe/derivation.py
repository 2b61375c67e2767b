"""The symbolic functions of one design: what is evaluated before and after its quadratic program is solved."""

from collections.abc import Sequence
from typing import Final

import casadi as ca

from passafe.barrier_chain import BarrierChain
from passafe.design import FilterDesign, Law
from passafe.intersample_margin import curvature_bound, held_function
from passafe.passivity import power_margin
from passafe.quadratic_program import certificate_residuals
from passafe.rows import TINY, ConstraintRow, continuous_rows, passivity_row, row_at, stack
from passafe.tracking import nominal_input, tracking_rate
from passafe.workspace import dense_function

NORM_CUTS: Final = 6
"""Tangents that a limit on the norm may be replaced by, at most, for each axis."""

NORM_TOLERANCE: Final = 1e-7
"""By how much an answer may be longer than asked for, relative to the norm's limit; so much less is asked for."""

OWN: Final = frozenset({"start", "u_lin", "trust_asked", "cushion"})
"""What the filter gives itself: always a number."""

CUSHION: Final = 2.0
"""By how much more than asked the rows are kept, in units of the residual that an answer may have."""

TANGENT_ERROR: Final = 1e-5
"""By how much u⁺ may miss a row that is not affine in u where no margin between samples is asked for, units of u."""

TRUST: Final = 1e-3
"""Change of u, relative to its magnitude, for which the margin between samples is good at least."""


class Derivation:
    """Functions and sizes that follow from a design.

    Rows of the whole program, N of them: the duties (barriers in the order of the design, then passivity), then of
    every axis the least and the largest input, then the tangents of the norm.

    Attributes:
        duties: Number of duties' rows.
        hard: Number of hard ones among them; they come first.
        k: Length of z: m, and one more if a row is soft.
        row_names: Names of all N rows.
        norm_asked: Length that answers are asked to have at most; 0 without a limit.
        has_margins: Whether there are margins between samples.
        root: √ρ of the soft row's slack; 0 without one.
        sizes_given: Parts read by ``prepare``, by name.
        sizes_derived: Parts that it writes.
        sizes_solved: Parts of an answer.
        sizes_judged: Parts that ``judge`` writes.
        first_cushion: What rows are first asked to be kept by beyond ε, units of u.
        prepare: given → derived.
        prepare_usual: The same where start is 0, u_lin is u, no trust is asked for and the cushion is the first one.
        judge: given, derived and solved → judged.
        judge_reads: Names of what ``judge`` reads.
        conflict: (G, d, relax, u_ref, low, high) → by how much the hard rows ask for more than the limits give.
        fail_safe: x → the fail-safe's input, not clipped.
    """

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain]) -> None:
        """Derive everything."""
        self._design = design
        self._system = system = design.system
        self._sampled = design.law is Law.SAMPLED
        m = system.m
        u_h, u_h_rate = ca.SX.sym("u_h", m), ca.SX.sym("u_h_rate", m)
        self._tank, self._start, self._cushion = ca.SX.sym("tank"), ca.SX.sym("start"), ca.SX.sym("cushion")
        self._u_lin, self._trust_asked = ca.SX.sym("u_lin", m), ca.SX.sym("trust_asked", m)
        self._given = {
            "x": system.x,
            "u": system.u,
            "u_h": u_h,
            "u_h_rate": u_h_rate,
            "tank": self._tank,
            "t": system.t,
            "start": self._start,
            "u_lin": self._u_lin,
            "trust_asked": self._trust_asked,
            "cushion": self._cushion,
        }
        self._u_nominal = nominal_input(design.u_fb, u_h)
        self._phi = tracking_rate(system, design.u_fb, u_h, u_h_rate, design.k_i)
        self._low, self._high = self._interval()
        wanted = ca.if_else(self._start, self._u_nominal, system.u + design.dt_s * self._phi)
        self._u_ref = ca.fmin(ca.fmax(wanted, self._low), self._high)
        nearby = ca.mmax(ca.fabs(self._u_ref - self._u_lin)) + TRUST * ca.DM(list(design.limits.magnitude))
        self._trust = ca.if_else(self._trust_asked > 0, self._trust_asked, nearby)
        self._chains = chains
        self._enforced = tuple(chains) if design.mode.enforces_safety else ()
        self._h_u = power_margin(system, design.passivity.V)
        self.has_margins = self._sampled and design.between_samples and bool(self._enforced)
        self._held = [held_function(system, chain, design.held_s) for chain in self._enforced]
        self._eps = ca.vertcat(ca.SX(0, 1), *(self._margin(chain) for chain in self._enforced))
        rows = self._rows()
        self.duties = len(rows)
        self.first_cushion = CUSHION * design.tolerance.residual if design.between_samples else 0.0
        self.hard = sum(row.slack_price is None for row in rows)
        cuts = 0 if design.limits.norm is None else NORM_CUTS * m
        # So much less that no answer that is accepted needs shortening: a shortened input would not be the nearest.
        self.norm_asked = (design.limits.norm or 0.0) * (1 - NORM_TOLERANCE)
        self._cuts = ca.SX.sym("cuts", cuts, m)
        self.row_names = (
            *(row.name for row in rows),
            *(f"input {i} low" for i in range(m)),
            *(f"input {i} high" for i in range(m)),
            *(f"norm {j}" for j in range(cuts)),
        )
        G, d, self.root = stack(rows, m, reach=design.limits.reach)
        self.k = G.shape[1]
        worst = ca.mmax(d) if rows else ca.SX(0)
        # fmin, fmax and mmax swallow a NaN; this is nothing for ordinary numbers and spoils the residual otherwise.
        asked = [symbol for name, symbol in self._given.items() if name not in OWN]
        parts = ca.vertcat(*asked, self._phi, *(row.value for row in rows))
        derived = {
            "u_nominal": self._u_nominal,
            "phi": self._phi,
            "u_ref": self._u_ref,
            "low": self._low,
            "high": self._high,
            "trust": self._trust,
            "eps": self._eps,
            "G": G,
            "d": d,
            "worst": worst,
            "poison": 1e-300 * ca.sumsqr(parts),
        }
        self.sizes_given = {name: symbol.numel() for name, symbol in self._given.items()}
        self.sizes_derived = {name: value.numel() for name, value in derived.items()}
        self.sizes_solved = {
            "z": self.k,
            "lam": len(self.row_names),
            "conflict": 1,
            "relax": self.hard,
            "cuts": cuts * m,
        }
        symbols = list(self._given.values())
        self.prepare = dense_function("prepare", symbols, list(derived.values()))
        # What nearly every tick evaluates, and alone: not the first input of all, margin and tangents about u.
        own = [self._start, self._u_lin, self._trust_asked, self._cushion]
        usual = [ca.SX(0), system.u, ca.SX.zeros(m), ca.SX(self.first_cushion)]
        self.prepare_usual = dense_function("prepare_usual", symbols, ca.substitute(list(derived.values()), own, usual))
        self.judge, self.sizes_judged = self._judging()
        self.conflict = self._conflict()
        self.fail_safe = dense_function("fail_safe", [system.x], [design.fail_safe])

    def _interval(self) -> tuple[ca.SX, ca.SX]:
        """Return the least and largest input; the first one of all is not bound by what was before it."""
        limits, design = self._design.limits, self._design
        low, high = limits.interval(design.system.u, design.dt_s)
        if limits.rate_per_s is None:
            return low, high
        b = ca.DM(list(limits.magnitude))
        return ca.if_else(self._start, -b, low), ca.if_else(self._start, b, high)

    def _margin(self, chain: BarrierChain) -> ca.SX:
        """Return ε for every input within ``trust`` of u_lin, in the unit of ψ_r; 0 where none is wanted."""
        design = self._design
        if not (self._sampled and design.between_samples):
            return ca.SX(0)
        r, held_s = chain.relative_degree, design.held_s
        p = chain.psi[r - 1]
        bound = curvature_bound(self._system, p, held_s, self._trust, steps=max(r, 2))
        margin = held_s / 2 * ca.fmax(ca.substitute(bound, self._system.u, self._u_lin), 0)
        # Outside the set there is nothing to keep between samples; on the way out the margin is given up by and by.
        return ca.fmax(ca.fmin(margin, margin + p / held_s), 0)

    def _rows(self) -> list[ConstraintRow]:
        design, system = self._design, self._system
        passivity = design.passivity if design.mode.enforces_passivity else None
        if not self._sampled:
            rate = (self._u_ref - system.u) / design.dt_s
            return continuous_rows(system, self._enforced, self._h_u, passivity, rate, design.dt_s)
        rows = []
        for i, (chain, held) in enumerate(zip(self._enforced, self._held, strict=True)):
            row = row_at(system, chain.barrier.name, held, self._u_ref, self._u_lin)
            length = ca.norm_2(row.gradient)
            rows.append(
                ConstraintRow(
                    name=row.name, value=row.value - self._eps[i] - self._cushion * length, gradient=row.gradient
                )
            )
        if passivity is not None:
            rows.append(passivity_row(system, self._h_u, passivity, self._u_ref, self._u_lin, self._tank))
        return rows

    def _judging(self) -> tuple[ca.Function, dict[str, int]]:
        """Return the function (given, derived, solved) → judged, and the sizes of what it returns."""
        design, system, limits = self._design, self._system, self._design.limits
        m, n_duties = system.m, self.duties
        phi, u_ref, low, high = (ca.SX.sym(name, m) for name in ("phi", "u_ref", "low", "high"))
        trust, eps = ca.SX.sym("trust", m), ca.SX.sym("eps", self._eps.numel())
        G, d, poison = ca.SX.sym("G", n_duties, self.k), ca.SX.sym("d", n_duties), ca.SX.sym("poison")
        z, lam = ca.SX.sym("z", self.k), ca.SX.sym("lam", len(self.row_names))
        relax = ca.SX.sym("relax", self.hard)
        G_all, d_all = self._whole(G, d, u_ref, low, high)
        relaxed = ca.vertcat(d_all[: self.hard] - relax, d_all[self.hard :])
        residuals = certificate_residuals(z, lam, G_all, relaxed)
        unclipped = u_ref + z[:m]
        u_plus = limits.clip(unclipped, system.u, low, high)
        norm_overreach = ca.SX(0) if limits.norm is None else ca.norm_2(unclipped) - self.norm_asked
        residuals[0] = residuals[0] + poison
        psi = ca.vertcat(ca.SX(0, 1), *(psi for chain in self._chains for psi in chain.psi))
        psi, h_u = ca.substitute([psi, self._h_u], [system.u], [u_plus])
        judged = {
            "margins": G_all @ z - d_all,
            "u_plus": u_plus,
            "v": (u_plus - system.u) / design.dt_s - phi,
            "psi": psi,
            "h_u": h_u,
            "residuals": residuals,
            "norm_overreach": norm_overreach,
            "slack": z[m] / self.root if self.root else ca.SX(0),
            "shortfall": self._shortfall(u_plus, eps),
            "strayed": self._strayed(u_plus, trust),
        }
        arguments = [
            *self._given.values(),
            *(phi, u_ref, low, high, trust, eps, G, d, poison),
            *(z, lam, relax, self._cuts),
        ]
        self.judge_reads = [
            *self._given,
            *("phi", "u_ref", "low", "high", "trust", "eps", "G", "d", "poison"),
            *("z", "lam", "relax", "cuts"),
        ]
        return (
            dense_function("judge", arguments, list(judged.values())),
            {name: value.numel() for name, value in judged.items()},
        )

    def _whole(self, G: ca.SX, d: ca.SX, u_ref: ca.SX, low: ca.SX, high: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the rows of the whole program, limits included, shapes (N, k) and (N, 1)."""
        m, cuts = self._system.m, self._cuts
        axes = ca.horzcat(ca.SX.eye(m), ca.SX(m, self.k - m))
        tangents = ca.horzcat(-cuts, ca.SX(cuts.shape[0], self.k - m))
        return (
            ca.vertcat(G, axes, -axes, tangents),
            ca.vertcat(d, low - u_ref, u_ref - high, cuts @ u_ref - self.norm_asked),
        )

    def _conflict(self) -> ca.Function:
        """Return (G, d, relax, u_ref, low, high) → by how much hard rows, so weighted, ask for too much (Farkas)."""
        m, limits = self._system.m, self._design.limits
        G, d = ca.SX.sym("G", self.duties, self.k), ca.SX.sym("d", self.duties)
        weights = ca.SX.sym("relax", self.hard)
        u_ref, low, high = (ca.SX.sym(name, m) for name in ("u_ref", "low", "high"))
        pull = ca.sum1(G[: self.hard, :m] * ca.repmat(weights, 1, m)).T
        most = ca.sum1(ca.fmax(pull * (low - u_ref), pull * (high - u_ref)))
        if limits.norm is not None:
            most = ca.fmin(most, limits.norm * ca.norm_2(pull) - ca.dot(pull, u_ref))
        asked = ca.sum1(weights * d[: self.hard]) if self.hard else ca.SX(0)
        return dense_function("conflict", [G, d, weights, u_ref, low, high], [asked - most])

    def _shortfall(self, u_plus: ca.SX, eps: ca.SX) -> ca.SX:
        """Return by how much u⁺ misses what keeps barriers at and between samples, units of u; ≤ 0 if it does not."""
        system, between = self._system, self._design.between_samples
        missing = [ca.SX(0)]
        for i, held in enumerate(self._held if self._sampled else ()):
            value, gradient = ca.substitute([held, ca.gradient(held, system.u)], [system.u], [u_plus])
            short = (eps[i] - value) / ca.fmax(ca.norm_2(gradient), TINY)
            if between:
                missing.append(short)
            elif ca.depends_on(ca.gradient(held, system.u), system.u):
                missing.append(short - TANGENT_ERROR)
        return ca.mmax(ca.vertcat(*missing))

    def _strayed(self, u_plus: ca.SX, trust: ca.SX) -> ca.SX:
        """Return by how much u⁺ is further from u_lin than the margins are good for; ≤ 0 if it is not."""
        if not self.has_margins:
            return ca.SX(0)
        return ca.mmax(ca.fabs(u_plus - self._u_lin) - trust)
