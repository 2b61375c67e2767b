"""Limits in scenario files: one number or a list, each side, norms of parts and half-spaces, from file to plant."""

import numpy as np
import pytest
from passafe_protocol.messages import FilterTick, PlantInput
from passafe_services.plant.input_check import InputCheck
from passafe_services.plant_contract.fail_safe import FailSafe
from passafe_services.scenarios.design import design_of, limits_of, robot_of
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.feasibility.batch_rows import StateRows
from passafe_services.tools.feasibility.largest_margin import largest_margin_inputs

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.limits import Limits
from passafe.models.damped_point import damped_point

TORQUES = (60.0, 45.0, 9.0)


def arm(**filter_keys: object) -> Scenario:
    """Return three joints that a constant command pushes against their limits."""
    return scenario_from(
        {
            "schema_version": 1,
            "name": "three-joints",
            "title": "three joints of unequal strength",
            "duration_s": 0.4,
            "rate_hz": 250.0,
            "plant": {"model": "joint-chain", "x0": [0.0] * 6},
            "operator": {"source": {"kind": "constant", "value": [30.0, -70.0, 25.0]}},
            "filter": {"k_i": 60.0, "passivity": {"storage": "kinetic"}, **filter_keys},
        },
        "arm.toml",
    )


def inputs_of(scenario: Scenario) -> tuple[np.ndarray, set[str]]:
    """Return the inputs that a filter sends, shape (K, m), and the statuses of its ticks."""
    sent, statuses = [], set()

    def take(_topic: object, _header: object, body: object) -> None:
        if isinstance(body, PlantInput):
            sent.append(body.u)
        elif isinstance(body, FilterTick):
            statuses.add(body.status.name)

    loop = lockstep_loop(scenario, take)
    loop.run(100)
    loop.finish()
    return np.array(sent), statuses


def test_every_joint_has_a_bound_of_its_own() -> None:
    scenario = arm(input_bound=TORQUES, input_rate_bound_per_s=2000.0)
    u, statuses = inputs_of(scenario)

    assert design_of(scenario, robot_of(scenario)).limits.high == TORQUES
    largest = np.abs(u).max(axis=0)
    assert largest[1:] == pytest.approx(TORQUES[1:], rel=1e-3)
    assert 9.0 < largest[0] <= TORQUES[0]
    assert statuses <= {"PASSED", "MODIFIED", "RELAXED", "STALE"}


def test_sides_rates_norms_and_half_spaces_reach_the_inputs() -> None:
    scenario = arm(
        input_low=[0.0, -20.0, -9.0],
        input_high=[60.0, 5.0, 9.0],
        input_norms=[{"axes": [0, 2], "bound": 25.0}],
        input_half_spaces=[{"weights": [1.0, -1.0, 0.0], "bound": 30.0}],
        input_rate_low_per_s=[-100.0, -500.0, -100.0],
        input_rate_high_per_s=800.0,
    )
    u, _ = inputs_of(scenario)
    steps = np.diff(u, axis=0) * scenario.rate_hz

    assert limits_of(scenario, robot_of(scenario)).excess(u.T).max() <= 1e-9
    assert u.min() >= -20.0
    assert u[:, 0].min() >= 0.0
    assert np.hypot(u[:, 0], u[:, 2]).max() <= 25.0 + 1e-9
    assert (u[:, 0] - u[:, 1]).max() == pytest.approx(30.0, abs=1e-3)
    assert (steps >= np.array([-100.0, -500.0, -100.0]) - 1e-6).all()
    assert steps.max() <= 800.0 + 1e-6


def test_numbers_are_taken_as_before() -> None:
    scenario = load_scenario("tight-limits")
    limits = limits_of(scenario, robot_of(scenario))

    assert (limits.high, limits.norm, limits.rise_per_s) == ((6.0, 6.0), 7.0, (200.0, 200.0))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"input_bound": [60.0, "strong", -1.0]}, r"input_bound\.1: got 'strong', allowed a number"),
        ({"input_bound": []}, "input_bound: got .*, allowed a list no shorter than 1"),
        ({"input_bound": "wide"}, "filter.input_bound: got 'wide', allowed a number"),
        ({"input_low": [0.0, None, 0.0]}, r"input_low\.1: got None, allowed a number"),
        ({"input_rate_low_per_s": 5.0}, "input_rate_low_per_s: got 5.0, allowed below 0"),
        ({"input_norms": [{"axes": [0], "bound": 0.0}]}, r"input_norms\.0\.bound: got 0.0, allowed above 0"),
        ({"input_norms": [{"axis": 0, "bound": 1.0}]}, "allowed axes, bound"),
        ({"input_half_spaces": [{"weights": [], "bound": 1.0}]}, "weights: got .*, allowed a list no shorter than 1"),
    ],
)
def test_what_is_no_limit_is_named(keys: dict[str, object], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        arm(**keys)


def test_lists_have_one_number_for_each_axis() -> None:
    scenario = arm(input_bound=[1.0, 2.0])

    with pytest.raises(ScenarioError, match=r"filter\.input_bound: got 2 numbers, allowed one number, or 3"):
        design_of(scenario, robot_of(scenario))


def test_limits_leave_some_input() -> None:
    scenario = arm(input_low=4.0, input_norm_bound=5.0)

    with pytest.raises(ScenarioError, match=r"filter\.input limits: got a set of inputs without an interior"):
        limits_of(scenario, robot_of(scenario))


LIMITS = Limits.of(
    3,
    None,
    low=(1.0, -4.0, -4.0),
    high=(9.0, 5.0, 4.0),
    norms=(NormBound(axes=(1, 2), bound=5.0),),
    half_spaces=(HalfSpace(weights=(1.0, 1.0, 0.0), bound=10.0),),
)


@pytest.mark.parametrize(
    ("u", "applicable"),
    [
        ((1.0, 0.0, 0.0), True),
        ((0.9, 0.0, 0.0), False),
        ((1.0, 3.0, 4.0), True),
        ((1.0, 3.1, 4.0), False),
        ((6.0, 4.0, 0.0), True),
        ((6.0, 4.1, 0.0), False),
        ((2.0, -4.1, 0.0), False),
        ((2.0, float("nan"), 0.0), False),
        ((2.0, 0.0), False),
    ],
)
def test_the_plant_checks_every_limit(u: tuple[float, ...], *, applicable: bool) -> None:
    assert InputCheck(LIMITS).is_applicable(u) is applicable


def test_what_the_filter_corrects_the_plant_applies() -> None:
    check, rng = InputCheck(LIMITS), np.random.default_rng(7)
    u, low, high = np.array(LIMITS.centre), np.array(LIMITS.low), np.array(LIMITS.high)
    for _ in range(200):
        u = LIMITS.nearest(rng.normal(size=3) * 20, u, low, high)
        assert check.is_applicable(tuple(u.tolist()))


def test_the_fail_safe_law_of_the_plant_is_within_all_limits() -> None:
    limits = Limits.of(
        2, None, low=(1.0, -3.0), high=(9.0, 3.0), half_spaces=(HalfSpace(weights=(1.0, 1.0), bound=4.0),)
    )
    rule = FailSafe(damped_point(sigma=1.0, gamma_1=10.0), limits, period_ns=1, hold_ns=0)

    assert rule.law((0.0, 0.0, 0.0, 0.0)) == (1.0, 0.0)
    assert rule.law((0.0, 0.0, -0.5, 0.0)) == pytest.approx((4.25, -0.25), abs=1e-5)


def test_no_input_within_general_limits_has_a_larger_margin() -> None:
    rng = np.random.default_rng(8)
    G = rng.normal(size=(30, 4, 3))
    rows = StateRows(G=G / np.linalg.norm(G, axis=2, keepdims=True), d=rng.normal(size=(30, 4)) * 4)
    u, t = largest_margin_inputs(rows, LIMITS)
    tried = rng.uniform(LIMITS.low, LIMITS.high, (4000, 3))

    assert LIMITS.excess(u.T).max() <= 1e-9
    assert rows.margin(u) == pytest.approx(t, abs=1e-4)
    for other in tried[LIMITS.excess(tried.T) <= 0]:
        assert (rows.margin(np.tile(other, (30, 1))) <= t + 1e-6).all()
