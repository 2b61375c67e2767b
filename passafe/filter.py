"""The safety and passivity filter: from a state and a request to a certified input.

Paper, proposition 2, with the rows of the chosen law. ``decide`` is a function of its arguments alone.
"""

import struct
from collections.abc import Sequence
from math import isfinite, sqrt

import casadi as ca

from passafe.barrier import BarrierChain, derive_chain
from passafe.decision import Decision, Status
from passafe.design import FilterDesign, Law
from passafe.errors import ShapeError
from passafe.passivity import power_margin
from passafe.piqp_solver import PiqpSolver, SolverOutcome
from passafe.quadratic_program import judging_function
from passafe.rows import continuous_rows, sampled_rows, stack
from passafe.tracking import nominal_input, tracking_rate
from passafe.workspace import Layout, Workspace, dense_function

BOUND_TOLERANCE = 1e-6
"""By how much the unclipped input may pass its bound before the rows count as infeasible, relative."""

# Reaching a member through its enumeration takes 0.7 µs on Python 3.11, and a step has 20.
_PASSED, _MODIFIED, _RELAXED, _UNCERTIFIED, _INFEASIBLE = Status
_SOLVED, _NO_SOLUTION, _FAILED = SolverOutcome


class SafetyPassivityFilter:
    """Solves and certifies one quadratic program for every request.

    Parts of a decision, by name (n states, m inputs, N rows): ``x`` n, ``u`` m (the input before), ``u_h`` m,
    ``u_h_rate`` m, ``tank`` 1, ``t`` 1, ``u_nominal`` m, ``phi`` m, ``u_ref`` m (the input if v = 0, within the bound),
    ``worst`` 1 (largest d), ``poison`` 1 (not a number or large where anything given or derived is),
    ``G`` N·k, ``d`` N, ``z`` k, ``lam`` N, ``margins`` N, ``u_plus`` m, ``v`` m, ``psi``, ``h_u`` 1,
    ``residuals`` 3, ``overreach`` 1, ``slack`` 1, ``conflict`` 1 (positive: the multipliers prove that the hard rows
    cannot be kept within the bound).

    Attributes:
        design: What it was derived from.
        chains: Barrier chains, in the order of the design.
        row_names: Names of the N rows, in the order of ``margins`` and ``lam``.
        layout: Places of the parts in a decision's block.
    """

    def __init__(self, design: FilterDesign) -> None:
        """Derive and compile everything.

        Raises:
            DesignError: Some part of the design cannot be used.
        """
        self.design = design
        system = design.system
        self.chains = tuple(derive_chain(system, barrier) for barrier in design.barriers)
        derivation = _Derivation(design, self.chains)
        self.row_names = derivation.row_names
        N, k = derivation.G.shape
        n, m, psi = system.n, system.m, derivation.psi.numel()
        given = {"x": n, "u": m, "u_h": m, "u_h_rate": m, "tank": 1, "t": 1}
        derived = {"u_nominal": m, "phi": m, "u_ref": m, "G": N * k, "d": N, "worst": 1, "poison": 1}
        solved = {"z": k, "lam": N}
        judged = {
            "margins": N,
            "u_plus": m,
            "v": m,
            "psi": psi,
            "h_u": 1,
            "residuals": 3,
            "overreach": 1,
            "slack": 1,
            "conflict": 1,
        }
        self.layout = Layout.of(given | derived | solved | judged)
        self._workspace = space = Workspace(self.layout)
        self._prepare = space.bind(derivation.prepare, list(given), list(derived))
        self._judge = space.bind(derivation.judge, [*given, "phi", "u_ref", "G", "d", "poison", *solved], list(judged))
        self._fail_safe = space.bind(derivation.fail_safe, ["x"], ["u_plus"])
        self._z, self._lam = space.part("z"), space.part("lam")
        self._z_memory, self._lam_memory = self._z.data, self._lam.data
        self._residual, self._gap = design.tolerance.residual, design.tolerance.gap
        self._overreach = BOUND_TOLERANCE * design.input_bound
        self._relaxed_above = design.passivity.relaxed_above
        self._solver = PiqpSolver(space.matrix("G", (N, k)), space.part("d")) if N else None
        self._lengths = n, m, m, m
        self._take = struct.Struct(f"{n + 3 * m + 2}d").pack_into
        self._worst = struct.Struct("d").unpack_from, self.layout.parts["worst"].start * 8
        self._verdict = struct.Struct("6d").unpack_from, self.layout.parts["residuals"].start * 8
        self._u_plus = struct.Struct(f"{m}d").unpack_from, self.layout.parts["u_plus"].start * 8

    def decide(
        self,
        x: Sequence[float],
        u: Sequence[float],
        u_h: Sequence[float],
        u_h_rate: Sequence[float],
        tank_j: float = 0.0,
        t_s: float = 0.0,
    ) -> Decision:
        """Return the input to hold over the next period.

        Args:
            x: State at which the input takes effect, n numbers.
            u: Input in force until then, m numbers.
            u_h: Operator's part of the input, m numbers.
            u_h_rate: Its time derivative, m numbers per second.
            tank_j: Energy E in the tank, J; without effect where the design has no tank.
            t_s: Plant time at which the input takes effect, s; without effect where no barrier moves.

        Returns:
            A decision for every argument whatever, NaN and infinity included: its u is finite and within the
            bound, its status says whether it is certified.

        Raises:
            ShapeError: An argument of the wrong length.
        """
        memory = self._workspace.memory
        lengths = (len(x), len(u), len(u_h), len(u_h_rate))
        if lengths != self._lengths:
            got, allowed = (", ".join(map(str, each)) for each in (lengths, self._lengths))
            raise ShapeError("x, u, u_h, u_h_rate", f"lengths {got}", f"lengths {allowed}")
        self._take(memory, 0, *x, *u, *u_h, *u_h_rate, tank_j, t_s)
        self._prepare()
        unpack, offset = self._worst
        outcome, solver = _SOLVED, "none"
        if self._solver is None or unpack(memory, offset)[0] <= 0.0:
            self._z.fill(0.0)
            self._lam.fill(0.0)
        else:
            outcome, solver = self._solver.solve(self._z_memory, self._lam_memory), self._solver.name
        self._judge()
        status = self._status(outcome, solver)
        if status >= _UNCERTIFIED:
            self._fall_back()
        unpack, offset = self._u_plus
        block = self._workspace.block.copy()
        return Decision(block, self.layout.parts, status, solver, unpack(memory, offset))

    def _status(self, outcome: SolverOutcome, solver: str) -> Status:
        unpack, offset = self._verdict
        primal, dual, gap, overreach, slack, conflict = unpack(self._workspace.memory, offset)
        if outcome is _NO_SOLUTION:
            return _INFEASIBLE if conflict > 0 else _UNCERTIFIED
        accepted = primal <= self._residual and dual <= self._residual and gap <= self._gap
        if outcome is not _SOLVED or not accepted:
            return _UNCERTIFIED
        if not overreach <= self._overreach:
            return _INFEASIBLE if conflict > 0 else _UNCERTIFIED
        if solver == "none":
            return _PASSED
        return _RELAXED if slack > self._relaxed_above else _MODIFIED

    def _fall_back(self) -> None:
        """Put the fail-safe law's input where the answer was, and what follows from it; keep the residuals."""
        space, bound = self._workspace, self.design.input_bound
        evidence = space.part("residuals").copy()
        self._fail_safe()
        u_plus = [min(max(value, -bound), bound) if isfinite(value) else 0.0 for value in space.part("u_plus")]
        self._z.fill(0.0)
        self._z[: len(u_plus)] = u_plus - space.part("u_ref")
        self._lam.fill(0.0)
        self._judge()
        space.part("u_plus")[:] = u_plus
        space.part("residuals")[:] = evidence


class _Derivation:
    """The symbolic functions of one design."""

    def __init__(self, design: FilterDesign, chains: Sequence[BarrierChain]) -> None:
        system, bound = design.system, design.input_bound
        m = system.m
        u_h, u_h_rate, tank = ca.SX.sym("u_h", m), ca.SX.sym("u_h_rate", m), ca.SX.sym("tank")
        given = [system.x, system.u, u_h, u_h_rate, tank, system.t]
        phi = tracking_rate(system, design.u_fb, u_h, u_h_rate, design.k_i)
        u_ref = ca.fmin(ca.fmax(system.u + design.dt_s * phi, -bound), bound)
        self.h_u = power_margin(system, design.passivity.V)
        enforced = chains if design.mode.enforces_safety else ()
        h_u = self.h_u if design.mode.enforces_passivity else None
        if design.law is Law.SAMPLED:
            rows = sampled_rows(system, enforced, h_u, design.passivity, u_ref, tank)
        else:
            rows = continuous_rows(
                system, enforced, h_u, design.passivity, (u_ref - system.u) / design.dt_s, design.dt_s
            )
        self.row_names = tuple(row.name for row in rows)
        self.G, d, self.root = stack(rows, m, reach=2 * bound * sqrt(m))
        worst = ca.mmax(d) if rows else ca.SX(0)
        # fmin, fmax and mmax swallow a NaN; this is nothing for ordinary numbers and spoils the residual otherwise.
        poison = 1e-300 * ca.sumsqr(ca.vertcat(*given, phi, *(row.value for row in rows)))
        self.hard = [i for i, row in enumerate(rows) if row.slack_price is None]
        self.prepare = dense_function(
            "prepare", given, [nominal_input(design.u_fb, u_h), phi, u_ref, self.G, d, worst, poison]
        )
        self.psi = ca.vertcat(ca.SX(0, 1), *(psi for chain in chains for psi in chain.psi))
        self.judge = self._judging(design, given)
        self.fail_safe = dense_function("fail_safe", [system.x], [design.fail_safe])

    def _judging(self, design: FilterDesign, given: list[ca.SX]) -> ca.Function:
        """Return the function (given, φ, u_ref, G, d, z, λ) → (margins, u⁺, v, ψ, h_u, residuals, overreach, δ)."""
        system, bound = design.system, design.input_bound
        m = system.m
        rows, size = self.G.shape
        phi, u_ref = ca.SX.sym("phi", m), ca.SX.sym("u_ref", m)
        G, d = ca.SX.sym("G", rows, size), ca.SX.sym("d", rows)
        z, lam = ca.SX.sym("z", size), ca.SX.sym("lam", rows)
        margins, residuals = judging_function(rows, size)(G, d, z, lam)
        unclipped = u_ref + z[:m]
        u_plus = ca.fmin(ca.fmax(unclipped, -bound), bound)
        v = (u_plus - system.u) / design.dt_s - phi
        psi, h_u = ca.substitute([self.psi, self.h_u], [system.u], [u_plus])
        poison = ca.SX.sym("poison")
        residuals[0] += poison
        # Farkas: weighted with any weights ≥ 0, the hard rows ask for more than any admissible input gives.
        weights = ca.fmax(lam[self.hard], 0)
        pull = (G[self.hard, :m].T @ weights) if self.hard else ca.SX.zeros(m)
        conflict = (
            ca.dot(weights, d[self.hard]) - bound * ca.norm_1(pull) + ca.dot(pull, u_ref) if self.hard else ca.SX(-1)
        )
        overreach = ca.mmax(ca.fabs(unclipped)) - bound
        slack = z[m] / self.root if self.root else ca.SX(0)
        return dense_function(
            "judge",
            [*given, phi, u_ref, G, d, poison, z, lam],
            [margins, u_plus, v, psi, h_u, residuals, overreach, slack, conflict],
        )
