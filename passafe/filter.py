"""The safety and passivity filter: from a state and a request to a certified input.

Paper, proposition 2, with the rows of the chosen law. ``decide`` is a function of its arguments alone, and has an
answer for all of them. Duties, in their order: a finite input within the limits; safety; passivity; what the operator
asks for.
"""

import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Final

import numpy as np

from passafe.barrier_chain import derive_chain
from passafe.decision import Decision, Status
from passafe.derivation import NORM_TOLERANCE, TRUST, Derivation
from passafe.design import FilterDesign
from passafe.errors import ShapeError
from passafe.solvers.daqp_solver import DaqpSolver
from passafe.solvers.least_distance_solver import LeastDistanceSolver
from passafe.solvers.least_violation import least_violation
from passafe.solvers.piqp_solver import PiqpSolver
from passafe.solvers.solver import SOLVED, Solver
from passafe.workspace import BlockLayout, Workspace

ATTEMPTS: Final = 14
"""How often margins and tangents are put where the answer was; the last margin is good for every input whatever."""

FULL_STEPS: Final = 3
SHORT_STEP: Final = 0.6
"""After so many attempts the margin is put only so far towards the answer: answers may go to and fro."""

CLOSER: Final = 0.5
NARROWER: Final = 0.1
"""What the margin is good for next: of the way to the answer, or of what it was good for before."""

RELAXED_NORM: Final = 1e4
"""How many times further beyond the norm it may be where hard rows are given up: shortening costs them little more."""

# Reaching a member through its enumeration takes 0.7 µs on Python 3.11, and a step has 20.
_PASSED: Final = Status.PASSED
_MODIFIED: Final = Status.MODIFIED
_RELAXED: Final = Status.RELAXED
_UNCERTIFIED: Final = Status.UNCERTIFIED
_INFEASIBLE: Final = Status.INFEASIBLE


class SafetyPassivityFilter:
    """Solves and certifies one quadratic program for every request.

    Parts of a decision, by name (n states, m inputs, N rows, H hard rows): ``x`` n, ``u`` m (the input before),
    ``u_h`` m, ``u_h_rate`` m, ``tank`` 1, ``t`` 1, ``u_nominal`` m, ``phi`` m, ``u_ref`` m (the input if v = 0,
    within the limits), ``low`` m, ``high`` m, ``G`` and ``d`` (rows of the duties), ``eps`` (margin of every enforced
    barrier between samples), ``z`` k, ``lam`` N, ``relax`` H (by how much hard rows that contradict one another are
    not asked to be kept), ``margins`` N, ``u_plus`` m, ``v`` m, ``psi``, ``h_u`` 1, ``residuals`` 3, ``slack`` 1,
    ``conflict`` 1 (positive: ``relax`` proves that the hard rows cannot be kept within the limits), ``shortfall`` 1.

    Attributes:
        design: What it was derived from.
        chains: Barrier chains, in the order of the design.
        row_names: Names of the N rows, in the order of ``margins`` and ``lam``: duties first, then limits.
        duties: Number of rows that are duties.
        layout: Places of the parts in a decision's block.
        derivation: The functions that it evaluates.
    """

    def __init__(self, design: FilterDesign) -> None:
        """Derive and compile everything.

        Raises:
            DesignError: Some part of the design cannot be used.
        """
        self.design = design
        system = design.system
        self.chains = tuple(derive_chain(system, barrier) for barrier in design.barriers)
        self.derivation = derivation = Derivation(design, self.chains)
        self.row_names, self.duties, self._hard = derivation.row_names, derivation.duties, derivation.hard
        N, k, n, m = len(self.row_names), derivation.k, system.n, system.m
        given, derived = derivation.sizes_given, derivation.sizes_derived
        judged = derivation.sizes_judged
        self.layout = BlockLayout.of(given | derived | derivation.sizes_solved | judged)
        self._workspace = space = Workspace(self.layout)
        self._prepare = space.bind(derivation.prepare, list(given), list(derived))
        self._prepare_usual = space.bind(derivation.prepare_usual, list(given), list(derived))
        self._judge = space.bind(derivation.judge, derivation.judge_reads, list(judged))
        self._weigh = space.bind(derivation.conflict, ["G", "d", "relax", "u_ref", "low", "high"], ["conflict"])
        self._fail_safe = space.bind(derivation.fail_safe, ["x"], ["u_plus"])
        self._n, self._m = n, m
        self._take = struct.Struct(f"{n + 5 * m + 4}d").pack_into
        self._worst = struct.Struct("2d").unpack_from, self.layout.parts["worst"].start * 8
        self._verdict = struct.Struct("7d").unpack_from, self.layout.parts["residuals"].start * 8
        self._u_plus = struct.Struct(f"{m}d").unpack_from, self.layout.parts["u_plus"].start * 8
        self._whole_was_solved = False
        self._z, self._lam, self._relax = space.part("z"), space.part("lam"), space.part("relax")
        self._solved = space.block[self.layout.parts["z"].start : self.layout.parts["relax"].stop]
        self._z_memory, self._lam_memory = self._z.data, self._lam.data
        self._duty_memory = self._lam[: self.duties].data
        self._residual, self._gap = design.tolerance.residual, design.tolerance.gap
        self._first_guess = (*(0.0,) * m, derivation.first_cushion)
        self._least_trust = TRUST * np.array(design.limits.magnitude)
        self._has_margins = derivation.has_margins
        self._relaxed_above = design.passivity.relaxed_above
        self._duty_rows = space.matrix("G", (self.duties, k)), space.part("d")
        self._first = PiqpSolver(*self._duty_rows) if self.duties else None
        # The whole program, limits included, is needed only where the duties' answer is beyond the limits.
        self._rows, self._bounds = np.zeros((N, k), order="F"), np.zeros(N)
        self._rows[self.duties :, :m] = np.vstack((np.eye(m), -np.eye(m), np.zeros((N - self.duties - 2 * m, m))))
        self._chain: tuple[Solver, ...] = tuple(
            kind(self._rows, self._bounds) for kind in (PiqpSolver, DaqpSolver, LeastDistanceSolver)
        )
        self._cuts = space.matrix("cuts", (N - self.duties - 2 * m, m))
        self._norm_asked = derivation.norm_asked
        self._too_long = NORM_TOLERANCE * (design.limits.norm or 0.0)

    def decide(
        self,
        x: Sequence[float],
        u: Sequence[float],
        u_h: Sequence[float],
        u_h_rate: Sequence[float],
        tank_j: float = 0.0,
        t_s: float = 0.0,
        *,
        start: bool = False,
    ) -> Decision:
        """Return the input to hold over the next period.

        Args:
            x: State at which the input takes effect, n numbers.
            u: Input in force until then, m numbers.
            u_h: Operator's part of the input, m numbers.
            u_h_rate: Its time derivative, m numbers per second.
            tank_j: Energy E in the tank, J; without effect where the design has no tank.
            t_s: Plant time at which the input takes effect, s; without effect where no barrier moves.
            start: Whether there was no input before: then the answer is the one nearest to û that keeps every row,
                limits of the rate left out, instead of the one nearest to u + dt·φ.

        Returns:
            A decision for every argument whatever, NaN and infinity included: its u is finite and within the
            limits, its status says whether it is certified.

        Raises:
            ShapeError: An argument of the wrong length.
        """
        n, m = self._n, self._m
        if len(x) != n or not len(u) == len(u_h) == len(u_h_rate) == m:
            got = ", ".join(str(len(each)) for each in (x, u, u_h, u_h_rate))
            raise ShapeError("x, u, u_h, u_h_rate", f"lengths {got}", f"lengths {n}, {m}, {m}, {m}")
        memory = self._workspace.memory
        self._take(memory, 0, *x, *u, *u_h, *u_h_rate, tank_j, t_s, start, *u, *self._first_guess)
        if self._too_long:
            self._cuts[:] = np.eye(1, self._m)  # ‖u‖ ≤ B says u₁ ≤ B, too
        status, solver, settled = self._solve(self._prepare if start else self._prepare_usual)
        if not settled and status is not _UNCERTIFIED:
            status, solver = self._settle(status)
        if status is _UNCERTIFIED:
            self._fall_back()
        unpack, offset = self._u_plus
        return Decision(self._workspace.block.copy(), self.layout.parts, status, solver, unpack(memory, offset))

    def _settle(self, status: Status) -> tuple[Status, str]:
        """Solve again with margins and tangents that suit the answer, for as long as that asks for others.

        Rows that conflict with a margin for inputs far and wide, or with tangents far away, need not with those near
        by: then the margin is for fewer, until it is for those near to one input alone, and tangents go half-way back.
        """
        space, least = self._workspace, self._least_trust
        u_plus, u_lin, trust, cushion = (space.part(name) for name in ("u_plus", "u_lin", "trust_asked", "cushion"))
        shortfall, strayed, solver = space.part("shortfall"), space.part("strayed"), "none"
        trust[:], before = space.part("trust"), u_lin.copy()
        for attempt in range(ATTEMPTS):
            if status is _INFEASIBLE:
                trust[:] = np.maximum(NARROWER * trust, least)
                u_lin += (before - u_lin) / 2
            else:
                before = u_lin.copy()
                if strayed[0] <= 0.0:
                    cushion += 2 * shortfall
                change = u_plus - u_lin
                trust[:] = CLOSER * np.abs(change).max() + least
                u_lin += change if attempt < FULL_STEPS else SHORT_STEP * change
            if attempt == ATTEMPTS - 1 and status is not _INFEASIBLE:
                trust[:] = self.design.limits.reach
            status, solver, settled = self._solve(self._prepare)
            if settled or status is _UNCERTIFIED or (status is _INFEASIBLE and (trust <= least).all()):
                return status, solver
        return (status if status is _INFEASIBLE else _UNCERTIFIED), solver

    def _solve(self, prepare: Callable[[], None]) -> tuple[Status, str, bool]:
        """Return the status of the present program's answer, whose it is, and whether margins and tangents suit it."""
        memory = self._workspace.memory
        prepare()
        unpack, offset = self._worst
        worst, poison = unpack(memory, offset)
        solver, outcome = "none", SOLVED
        first = self._first
        if worst > 0.0 and first is not None:
            if self._whole_was_solved:  # else all but what the solver writes is zero
                self._whole_was_solved = False
                self._solved.fill(0.0)
            solver, outcome = first.name, first.solve(self._z_memory, self._duty_memory)
        else:
            self._solved.fill(0.0)
        self._judge()
        unpack, offset = self._verdict
        primal, dual, gap, too_long, slack, shortfall, strayed = unpack(memory, offset)
        accepted = primal <= self._residual and dual <= self._residual and gap <= self._gap
        if outcome is SOLVED and accepted and too_long <= self._too_long:
            settled = shortfall <= 0.0 and strayed <= 0.0
            if solver == "none":
                return _PASSED, solver, settled
            return (_RELAXED if slack > self._relaxed_above else _MODIFIED), solver, settled
        return self._solve_whole() if poison <= 1.0 else (_UNCERTIFIED, solver, False)

    def _solve_whole(self) -> tuple[Status, str, bool]:
        """Solve with the limits among the rows; if the hard ones contradict one another, with as few less as can be."""
        self._whole_was_solved = True
        solver: str | None = None
        for _ in self._tangents():
            solver = self._certified() or self._certified_with_less()
            if solver is None:
                break
        if solver is None:
            return _UNCERTIFIED, "none", False
        unpack, offset = self._verdict
        *_, slack, shortfall, strayed = unpack(self._workspace.memory, offset)
        if not self._is_short_enough():
            return _UNCERTIFIED, solver, False
        if self._relax.any():
            self._weigh()
            proven = self._workspace.part("conflict")[0] > 0.0
            return (_INFEASIBLE if proven else _UNCERTIFIED), solver, not self._has_margins
        settled = shortfall <= 0.0 and strayed <= 0.0
        return (_RELAXED if slack > self._relaxed_above else _MODIFIED), solver, settled

    def _tangents(self) -> Iterator[None]:
        """Give one tangent of the norm's limit after the other, each where the answer before was beyond it."""
        m, space = self._m, self._workspace
        self._rows[: self.duties], self._bounds[: self.duties] = self._duty_rows
        self._write_limits()
        yield
        for cut in self._cuts:
            if self._is_short_enough():
                return
            answer = space.part("u_ref") + self._z[:m]
            cut[:] = answer / np.linalg.norm(answer)
            self._write_limits()
            yield

    def _is_short_enough(self) -> bool:
        too_long = self._workspace.part("norm_overreach")[0]
        return bool(too_long <= self._too_long * (RELAXED_NORM if self._relax.any() else 1.0))

    def _write_limits(self) -> None:
        space, first, m = self._workspace, self.duties, self._m
        u_ref = space.part("u_ref")
        self._bounds[first : first + m] = space.part("low") - u_ref
        self._bounds[first + m : first + 2 * m] = u_ref - space.part("high")
        if len(self._cuts):
            self._rows[first + 2 * m :, :m] = -self._cuts
            self._bounds[first + 2 * m :] = self._cuts @ u_ref - self._norm_asked

    def _certified(self) -> str | None:
        """Return the first solver whose answer to the whole, relaxed program passes the certificate."""
        self._bounds[: self._hard] = self._duty_rows[1][: self._hard] - self._relax
        unpack, offset = self._verdict
        for solver in self._chain:
            outcome = solver.solve(self._z_memory, self._lam_memory)
            self._judge()
            primal, dual, gap, *_ = unpack(self._workspace.memory, offset)
            if outcome is SOLVED and primal <= self._residual and dual <= self._residual and gap <= self._gap:
                return solver.name
        return None

    def _certified_with_less(self) -> str | None:
        """Ask as little less of the hard rows as possible; return whose answer to that passes the certificate."""
        hard, m = self._hard, self._m
        least = least_violation(
            self._rows[:hard, :m],
            self._duty_rows[1][:hard],
            self._rows[self.duties :, :m],
            self._bounds[self.duties :],
        )
        if least is None:
            return None
        self._relax[:] = least
        return self._certified()

    def _fall_back(self) -> None:
        """Put the fail-safe law's input where the answer was, and what follows from it; keep the residuals."""
        space = self._workspace
        evidence = space.part("residuals").copy()
        self._fail_safe()
        u_plus = self.design.limits.nearest(*(space.part(name) for name in ("u_plus", "u", "low", "high")))
        self._solved.fill(0.0)
        self._z[: self._m] = u_plus - space.part("u_ref")
        self._judge()
        space.part("u_plus")[:] = u_plus
        space.part("residuals")[:] = evidence
