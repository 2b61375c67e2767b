"""Linear algebra in a fixed order agrees with LAPACK's and with what defines it."""

import numpy as np
import pytest
from scipy.linalg import expm, matrix_balance

from passafe.numerics.fixed_order import (
    balancing,
    cholesky,
    exponential,
    inner,
    largest_gain,
    least_squares,
    length,
    product,
    solution,
    spectral_radius,
)

SEEDS = range(40)


def drawn(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng([60, seed]).normal(size=shape)


@pytest.mark.parametrize(
    "shapes", [((3,), (3,)), ((3,), (3, 2)), ((4, 3), (3,)), ((4, 3), (3, 2)), ((5, 4, 3), (3, 2))]
)
def test_products_are_those_of_matmul(shapes: tuple[tuple[int, ...], tuple[int, ...]]) -> None:
    A, B = (drawn(k, *shape) for k, shape in enumerate(shapes))
    assert product(A, B) == pytest.approx(A @ B, rel=1e-14, abs=1e-14)


def test_inner_products_and_lengths() -> None:
    assert inner(np.array([1.0, 2.0]), np.array([3.0, 4.0])) == 11.0
    assert length(np.array([3.0, 4.0])) == 5.0


@pytest.mark.parametrize("size", [0.0, 1e-3, 1.0, 30.0])
def test_exponential_is_that_of_scipy(size: float) -> None:
    A = size * drawn(1, 5, 5)
    assert exponential(A) == pytest.approx(expm(A), rel=1e-12, abs=1e-12 * float(np.abs(expm(A)).max()))


def test_exponential_of_a_chain_of_integrators_is_exact() -> None:
    flow = exponential(np.diag([0.25, 0.25], 1))
    assert flow.tolist() == [[1.0, 0.25, 0.03125], [0.0, 1.0, 0.25], [0.0, 0.0, 1.0]]


@pytest.mark.parametrize("seed", SEEDS)
def test_least_squares_are_the_shortest_ones(seed: int) -> None:
    m, n, rank = (int(k) for k in np.random.default_rng([61, seed]).integers((1, 1, 0), 7))
    A, b = drawn(seed, m, rank) @ drawn(seed + 100, rank, n), drawn(seed + 200, m)
    assert least_squares(A, b, 1e-10) == pytest.approx(np.linalg.lstsq(A, b, rcond=1e-10)[0], rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_solution_solves_for_vectors_and_matrices(seed: int) -> None:
    A, b = drawn(seed, 4, 4), drawn(seed + 100, 4, 3)
    for asked in (b, b[:, 0]):
        x = solution(A, asked)
        assert x is not None
        assert A @ x == pytest.approx(asked, rel=1e-10, abs=1e-10)


def test_a_singular_matrix_has_no_solution() -> None:
    assert solution(np.array([[1.0, 2.0], [2.0, 4.0]]), np.ones(2)) is None


@pytest.mark.parametrize("seed", SEEDS)
def test_radius_and_gain_bound_eigenvalues_and_lengths(seed: int) -> None:
    A = drawn(seed, 4, 4)
    assert spectral_radius(A) == pytest.approx(np.abs(np.linalg.eigvals(A)).max(), rel=1e-10)
    found, gain = float(largest_gain(4)(A)), np.linalg.norm(A, 2)
    assert gain * (1 - 1e-14) <= found <= gain * (1 + 1e-7)


@pytest.mark.parametrize("A", [np.array([[0.0, 1.0], [0.0, 0.0]]), np.zeros((2, 2)), np.zeros((0, 0))])
def test_radius_of_a_nilpotent_matrix_is_zero(A: np.ndarray) -> None:
    assert spectral_radius(A) == 0.0


def test_gain_of_nothing_is_zero() -> None:
    assert float(largest_gain(2)(np.zeros((2, 2)))) == 0.0


def test_root_is_that_of_cholesky() -> None:
    A = drawn(3, 5, 5)
    P = A.T @ A + np.eye(5)
    assert cholesky(P) == pytest.approx(np.linalg.cholesky(P).T, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_balancing_is_that_of_lapack(seed: int) -> None:
    units = np.random.default_rng([63, seed]).uniform(-9, 9, 4)
    A = drawn(seed, 4, 4) * 10**units / 10 ** units[:, None]
    assert balancing(A).tolist() == matrix_balance(A, permute=False, separate=True)[1][0].tolist()


def test_balancing_leaves_alone_what_is_not_coupled() -> None:
    assert balancing(np.diag([1.0, 1e9])).tolist() == [1.0, 1.0]


def test_balancing_ends_after_its_sweeps(monkeypatch: pytest.MonkeyPatch) -> None:
    A = np.array([[1.0, 2.0**40], [2.0**-40, 1.0]])
    whole = balancing(A)
    monkeypatch.setattr("passafe.numerics.fixed_order.BALANCE_SWEEPS", 1)
    scale = balancing(A)

    assert scale.tolist() != [1.0, 1.0]
    assert np.array_equal(np.log2(scale), np.round(np.log2(scale)))
    assert np.isfinite(whole).all()
