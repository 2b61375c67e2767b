from math import nan

import numpy as np
import pytest
from program_residuals import residuals_of
from random_programs import KINDS, Array, random_programs
from two_row_oracle import solve_exactly

import passafe.program.solvers.least_distance_solver
import passafe.program.solvers.nonnegative
from passafe.certificate import Tolerance, accepts
from passafe.program.solvers.daqp_solver import DaqpSolver
from passafe.program.solvers.least_distance_solver import LeastDistanceSolver
from passafe.program.solvers.piqp_solver import PiqpSolver
from passafe.program.solvers.solver import Solver, SolverOutcome

EASY = ("generic", "parallel", "duplicated", "nearly parallel")
Kind = type[PiqpSolver] | type[DaqpSolver] | type[LeastDistanceSolver]
KINDS_OF_SOLVER: dict[str, Kind] = {"piqp": PiqpSolver, "daqp": DaqpSolver, "ldp": LeastDistanceSolver}

pytestmark = pytest.mark.parametrize("name", KINDS_OF_SOLVER)


def at_work(name: str, size: int) -> tuple[Solver, Array, Array]:
    G, d = np.zeros((2, size), order="F"), np.zeros(2)
    return KINDS_OF_SOLVER[name](G, d), G, d


def test_far_row_is_no_conflict_beside_a_near_one(name: str) -> None:
    solver, G, d = at_work(name, 2)
    z, lam = np.zeros(2), np.zeros(2)
    G[:], d[:] = np.eye(2), (1e8, -0.5)

    assert solver.solve(z.data, lam.data) is SolverOutcome.SOLVED
    assert z == pytest.approx([1e8, 0.0], rel=1e-3, abs=1e3)


@pytest.mark.parametrize("size", [1, 2, 3])
def test_answers_are_the_closed_form_ones(name: str, size: int) -> None:
    solver, G, d = at_work(name, size)
    z, lam = np.zeros(size), np.zeros(2)
    for kind, rows, bounds in random_programs(30, 1200, size, EASY if size > 1 else ("duplicated", "parallel")):
        G[:], d[:] = rows, bounds
        exact = solve_exactly(rows, bounds)
        outcome = solver.solve(z.data, lam.data)

        assert exact is not None
        if np.linalg.norm(exact.z) > 200:
            continue  # further than any admissible input: what is said of it does not matter
        assert outcome is SolverOutcome.SOLVED, (kind, rows, bounds)
        assert z == pytest.approx(exact.z, abs=2e-4 * (1 + float(np.linalg.norm(exact.z))))
        assert lam.min() >= -1e-6


@pytest.mark.parametrize("size", [2, 3])
def test_conflicts_are_never_called_solved(name: str, size: int) -> None:
    solver, G, d = at_work(name, size)
    z, lam = np.zeros(size), np.zeros(2)
    conflicts = 0
    for _, rows, bounds in random_programs(31, 800, size, ("antiparallel", "without gradient")):
        # Closer conflicts than the residual tolerance are answered in between, which the certificate accepts.
        if solve_exactly(rows, bounds - 1e-4) is not None:
            continue
        G[:], d[:] = rows, bounds
        conflicts += 1

        assert solver.solve(z.data, lam.data) is not SolverOutcome.SOLVED
    assert conflicts > 100


def test_says_infeasible_of_a_plain_conflict(name: str) -> None:
    solver, G, d = at_work(name, 2)
    G[:], d[:] = [[1.0, 0.0], [-1.0, 0.0]], [1.0, 1.0]

    assert solver.solve(np.zeros(2).data, np.zeros(2).data) is SolverOutcome.INFEASIBLE


@pytest.mark.parametrize("place", range(4))
def test_a_gradient_that_is_no_number_is_never_certified(name: str, place: int) -> None:
    solver, G, d = at_work(name, 2)
    G[:], d[:] = np.eye(2), [1.0, 2.0]
    G.flat[place] = nan
    z, lam = np.zeros(2), np.zeros(2)

    solved = solver.solve(z.data, lam.data) is SolverOutcome.SOLVED
    assert not (solved and accepts(Tolerance(), residuals_of(G, d, z, lam)))


def test_an_answer_does_not_depend_on_the_problems_before(name: str) -> None:
    solver, G, d = at_work(name, 2)
    programs = [(rows, bounds) for _, rows, bounds in random_programs(32, 200, 2, KINDS)]
    programs.insert(100, (np.full((2, 2), nan), np.array([1.0, 1.0])))
    programs.insert(150, (np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, 1.0])))

    def answer(k: int) -> tuple[SolverOutcome, bytes, bytes]:
        z, lam = np.zeros(2), np.zeros(2)
        G[:], d[:] = programs[k]
        return solver.solve(z.data, lam.data), z.tobytes(), lam.tobytes()

    forwards = [answer(k) for k in range(len(programs))]
    shuffled = np.random.default_rng(33).permutation(len(programs))

    assert {int(k): answer(k) for k in shuffled} == dict(enumerate(forwards))


def test_is_known_by_name(name: str) -> None:
    assert at_work(name, 2)[0].name == name


def test_an_iteration_that_does_not_end_has_failed(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe.program.solvers.nonnegative, "STEPS", 0)
    solver, G, d = at_work(name, 2)
    G[:], d[:] = np.eye(2), [1.0, 2.0]

    outcome = solver.solve(np.zeros(2).data, np.zeros(2).data)
    assert outcome is (SolverOutcome.FAILED if name == "ldp" else SolverOutcome.SOLVED)


def test_an_answer_beyond_all_numbers_is_none(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Least squares that end with r of no last entry put the nearest point at infinity."""
    module = passafe.program.solvers.least_distance_solver
    monkeypatch.setattr(module, "nonnegative_least_squares", lambda E, _f: np.eye(E.shape[1])[0])
    solver, G, d = at_work(name, 2)
    G[:], d[:] = np.eye(2), [5.0, 2.0]

    outcome = solver.solve(np.zeros(2).data, np.zeros(2).data)
    assert outcome is (SolverOutcome.FAILED if name == "ldp" else SolverOutcome.SOLVED)
