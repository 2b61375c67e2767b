"""The human-input estimator against closed forms, a batch solution and the Riccati equation."""

from math import inf, nan, sqrt
from random import Random

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from passafe.errors import DesignError
from passafe.human_input import GAP_S, KEPT, LARGEST, NEAR_S, HandModel, HumanInput, HumanInputEstimator

MODEL = HandModel(agility=10.0, resolution=2 / 64, horizon_s=0.05, fade_s=0.2)
INTENSITY = 12.0 * (10.0 * 32) ** 2


def fed(samples: list[tuple[float, tuple[float, ...]]], model: HandModel = MODEL) -> HumanInputEstimator:
    estimator = HumanInputEstimator(model, len(samples[0][1]))
    for time_s, sample in samples:
        estimator.add(time_s, sample)
    return estimator


def irregular(count: int, least_s: float = 0.001) -> list[tuple[float, tuple[float, float]]]:
    random, t, samples = Random(3), 5.0, []
    for _ in range(count):
        t += random.uniform(least_s, 0.08)
        samples.append((t, (random.uniform(-1, 1), random.uniform(-1, 1))))
    return samples


def transition(dt: float) -> tuple[np.ndarray, np.ndarray]:
    F = np.array([[1.0, dt], [0.0, 1.0]])
    return F, INTENSITY * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])


def test_before_a_sample_and_after_a_restart_it_is_zero() -> None:
    estimator = HumanInputEstimator(MODEL, 2)
    zero = HumanInput((0.0, 0.0), (0.0, 0.0))

    assert estimator.at(1.0) == zero
    estimator.add(1.0, (3.0, 4.0))
    estimator.restart()
    assert estimator.at(1.0) == zero


def test_first_sample_is_the_value_with_an_unknown_rate() -> None:
    assert fed([(1.0, (3.0, -4.0))]).at(1.04) == HumanInput((3.0, -4.0), (0.0, 0.0))


def test_a_constant_is_followed_exactly() -> None:
    estimator = fed([(t, (0.7, 0.0)) for t, _ in irregular(50)])

    assert estimator.at(9.0) == HumanInput((0.7, 0.0), (0.0, 0.0))


def test_constant_velocity_is_followed_without_lag() -> None:
    samples = [(t, (2.0 + 3.0 * t, -t)) for t, _ in irregular(200)]
    newest_s = samples[-1][0]

    u_h, rate = fed(samples).at(newest_s + 0.03)

    assert rate == pytest.approx((3.0, -1.0), abs=1e-9)
    assert u_h == pytest.approx((2.0 + 3.0 * (newest_s + 0.03), -(newest_s + 0.03)), abs=1e-9)


def test_the_second_sample_is_weighed_against_what_a_rate_may_be() -> None:
    dt, z = 0.001, 2 / 64
    p_uu, p_ur = 1 + dt**2 * INTENSITY * (1 + dt / 3), dt * INTENSITY * (1 + dt / 2)

    (u_h,), (rate,) = fed([(0.0, (0.0,)), (dt, (z,))]).at(dt)

    assert (u_h, rate) == pytest.approx((z * p_uu / (p_uu + 1), z * p_ur / (p_uu + 1)), rel=1e-12)
    assert rate < 0.4 * z / dt  # a finite difference would take one step of the quantisation at its word


def test_estimate_is_the_least_squares_solution_of_all_samples() -> None:
    """Unknowns: value and rate at every sample; equations weighted by the inverse square roots of their variances."""
    samples = irregular(12)
    size = 2 * len(samples)
    rows, right = [], []

    def equation(weights: np.ndarray, blocks: dict[int, np.ndarray], value: np.ndarray) -> None:
        row = np.zeros((len(weights), size))
        for i, block in blocks.items():
            row[:, 2 * i : 2 * i + 2] = weights @ block
        rows.append(row)
        right.append(weights @ value)

    start = np.diag([1.0, 1.0 / sqrt(INTENSITY)])
    equation(start, {0: np.eye(2)}, np.array([samples[0][1][0], 0.0]))
    for i in range(1, len(samples)):
        F, Q = transition(samples[i][0] - samples[i - 1][0])
        equation(np.linalg.inv(np.linalg.cholesky(Q)), {i: np.eye(2), i - 1: -F}, np.zeros(2))
        equation(np.eye(1), {i: np.array([[1.0, 0.0]])}, np.array([samples[i][1][0]]))
    solution = np.linalg.lstsq(np.vstack(rows), np.concatenate(right), rcond=None)[0]

    got = fed(samples).at(samples[-1][0])

    assert (got.u_h[0], got.u_h_rate[0]) == pytest.approx(solution[-2:], rel=1e-6)


@pytest.mark.parametrize("dt", [0.001, 0.01, 0.05])
def test_the_gains_settle_where_the_riccati_equation_says(dt: float) -> None:
    F, Q = transition(dt)
    H = np.array([[1.0, 0.0]])
    P = solve_discrete_are(F.T, H.T, Q, np.eye(1))
    gains = P[:, 0] / (P[0, 0] + 1.0)
    count = 400
    samples = [(i * dt, (0.0,)) for i in range(count)]
    before = fed(samples).at((count - 1) * dt)
    after = fed([*samples, (count * dt, (1.0,))]).at(count * dt)

    assert before == HumanInput((0.0,), (0.0,))
    assert (after.u_h[0], after.u_h_rate[0]) == pytest.approx(tuple(gains), rel=1e-6)


def test_overtaken_and_repeated_samples_end_in_the_same_bits() -> None:
    samples = irregular(40, NEAR_S)
    shuffled = samples[1:]
    Random(1).shuffle(shuffled)
    repeated = [sample for each in shuffled for sample in (each, each)]

    assert fed([samples[0], *repeated]).at(20.0) == fed(samples).at(20.0)
    assert fed([samples[0], *repeated]).at(samples[-1][0]) == fed(samples).at(samples[-1][0])


def test_accepted_and_ignored_commands_are_distinguished() -> None:
    estimator = HumanInputEstimator(MODEL, 1)

    assert [estimator.add(t, (0.0,)) for t in (1.0, 2.0, 1.5, 1.5, 2.0, 0.5)] == [True, True, True, False, False, False]


@pytest.mark.parametrize("time_s", [1.0 + 0.9 * NEAR_S, 2.0 - 0.9 * NEAR_S, 1.0, 2.0])
def test_overtaken_sample_is_ignored_only_near_another(time_s: float) -> None:
    samples = [(1.0, (0.0,)), (2.0, (1.0,))]
    estimator = fed(samples)

    assert not estimator.add(time_s, (9.0,))
    assert estimator.at(2.0) == fed(samples).at(2.0)
    assert estimator.add(2.0 + 0.01 * NEAR_S, (1.0,))


def test_what_is_older_than_all_that_is_kept_is_ignored() -> None:
    samples = [(0.01 * i, (0.001 * i,)) for i in range(KEPT + 10)]
    estimator = fed(samples)

    assert not estimator.add(0.055, (9.0,))
    assert estimator.add(0.105, (0.01,))
    assert not estimator.add(0.105, (0.01,))


@pytest.mark.parametrize(
    ("time_s", "sample"),
    [(2.0, (nan,)), (2.0, (inf,)), (2.0, (-2 * LARGEST,)), (nan, (1.0,)), (inf, (1.0,)), (2.0, ()), (2.0, (1.0, 2.0))],
)
def test_a_bad_sample_is_ignored(time_s: float, sample: tuple[float, ...]) -> None:
    estimator = fed([(1.0, (1.0,)), (1.1, (1.5,))])
    before = estimator.at(1.2)

    assert not estimator.add(time_s, sample)
    assert estimator.at(1.2) == before


def test_beyond_the_horizon_the_rate_fades_linearly_to_zero() -> None:
    estimator = fed([(0.1 * i, (0.1 * i,)) for i in range(60)])
    newest_s = 0.1 * 59
    u, rate = (part[0] for part in estimator.at(newest_s))

    for ahead_s, reach_s, left in ((0.05, 0.05, 1.0), (0.15, 0.125, 0.5), (0.25, 0.15, 0.0), (inf, 0.15, 0.0)):
        got = estimator.at(newest_s + ahead_s)
        assert got.u_h[0] == pytest.approx(u + reach_s * rate, abs=1e-12)
        assert got.u_h_rate[0] == pytest.approx(left * rate, abs=1e-12)
    assert estimator.at(inf).u_h_rate == (0.0,)


@pytest.mark.parametrize("ahead_s", [0.01, 0.1, 0.2])
def test_the_rate_is_the_derivative_of_the_value_at_all_times(ahead_s: float) -> None:
    estimator = fed(irregular(20))
    at_s, step_s = irregular(20)[-1][0] + ahead_s, 1e-6
    before, after = estimator.at(at_s - step_s).u_h, estimator.at(at_s + step_s).u_h

    slopes = [(b - a) / (2 * step_s) for a, b in zip(before, after, strict=True)]
    assert slopes == pytest.approx(estimator.at(at_s).u_h_rate, rel=1e-5)


@pytest.mark.parametrize("time_s", [-inf, 0.0, nan])
def test_a_time_before_the_newest_sample_counts_as_that_samples(time_s: float) -> None:
    estimator = fed(irregular(20))

    assert estimator.at(time_s) == estimator.at(irregular(20)[-1][0])


def test_after_a_long_gap_it_starts_anew() -> None:
    estimator = fed([(0.0, (0.0,)), (0.1, (1.0,)), (0.1 + 1.01 * GAP_S, (5.0,))])

    assert estimator.at(0.1 + 1.01 * GAP_S) == HumanInput((5.0,), (0.0,))


@pytest.mark.parametrize("ratio", [1e-3, 1e5])
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_hostile_samples_never_make_it_anything_but_finite(ratio: float, scale: float) -> None:
    model = HandModel(agility=ratio * scale, resolution=scale, horizon_s=0.0, fade_s=0.001)
    random, estimator, t = Random(7), HumanInputEstimator(model, 2), 0.0
    for _ in range(3000):
        t += random.choice((1e-9, 1e-6, 1e-3, 0.1, 0.999, 2.0, -0.05))
        estimator.add(t, (random.choice((-LARGEST, LARGEST, 5e-324, nan, 1.0)), random.uniform(-1, 1)))
        got = estimator.at(t + random.choice((0.0, 0.0005, 1e300)))
        assert np.isfinite([*got.u_h, *got.u_h_rate]).all()
        assert estimator._beliefs[-1].p_rr >= 0.0


def test_two_estimators_agree_to_the_last_bit() -> None:
    assert fed(irregular(300)).at(30.0) == fed(irregular(300)).at(30.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("agility", 0.0),
        ("agility", nan),
        ("resolution", inf),
        ("resolution", 1e-10),
        ("agility", 1e-6),
        ("agility", 1e4),
        ("horizon_s", -0.1),
        ("fade_s", 0.0),
    ],
)
def test_a_model_that_cannot_work_is_refused(name: str, value: float) -> None:
    settings = {"agility": 10.0, "resolution": 0.03, "horizon_s": 0.0, "fade_s": 0.2} | {name: value}

    with pytest.raises(DesignError, match=name):
        HandModel(**settings)


def test_without_inputs_there_is_nothing_to_estimate() -> None:
    with pytest.raises(DesignError, match="inputs"):
        HumanInputEstimator(MODEL, 0)
