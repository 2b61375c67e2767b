"""The rows at many states are those of the filter at each of them, and the best input for them is the best."""

import numpy as np
import pytest
from closed_form_designs import mass
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.feasibility.batch_rows import BatchRows, StateRows
from passafe_services.tools.feasibility.largest_margin import largest_margin_inputs
from passafe_services.tools.feasibility.share import random_states

from passafe.filter import SafetyPassivityFilter
from passafe.limits import Limits


@pytest.mark.parametrize("name", ["walls-and-disks", "moving-disk", "notomista-cai-2020"])
def test_hard_rows_are_those_of_the_filter(name: str) -> None:
    scenario = load_scenario(name)
    design = design_of(scenario, robot_of(scenario))
    filtering, many, m = SafetyPassivityFilter(design), BatchRows(design, 0.3), design.system.m
    states = random_states([-2.0] * design.system.n, [2.0] * design.system.n, 20, 3)
    tank = design.passivity.tank
    level_j = 0.0 if tank is None else tank.initial_j
    for x in states.T:
        decision = filtering.decide(x.tolist(), (0.0,) * m, (0.0,) * m, (0.0,) * m, level_j, 0.3, start=True)
        hard = len(design.barriers)
        rows = many.rows(x[:, None], decision.part("u_lin")[None], decision.part("trust")[None], passive=False)
        kept = rows.G[0] @ np.array(decision.u) - rows.d[0]
        extra = decision.part("tightening")[0] - 2e-6
        furthest = design.limits.reach
        near = np.abs(kept) < furthest  # beyond that, bounds are drawn in

        assert kept[near] == pytest.approx(decision.margins[:hard][near] + extra, abs=1e-7)
        assert np.linalg.norm(rows.G[0], axis=1) == pytest.approx(np.ones(hard))


@pytest.mark.parametrize("kind", ["power", "tank"])
def test_the_passivity_row_is_the_power_margin_in_units_of_u(kind: str) -> None:
    """∂h_u/∂u = x₂ − ∂V/∂x₂ = −x₂ with V = ‖x‖²."""
    scenario = load_scenario("notomista-cai-2020", {"filter.passivity.kind": kind, "filter.between_samples": False})
    design = design_of(scenario, robot_of(scenario))
    tank, many, m = design.passivity.tank, BatchRows(design, 0.0), design.system.m
    filtering = SafetyPassivityFilter(design)
    spendable = 0.0 if tank is None else tank.rate_per_s * (tank.initial_j - tank.reserve_j)
    level_j = 0.0 if tank is None else tank.initial_j
    for x in random_states([-2.0] * 4, [2.0] * 4, 20, 5).T:
        decision = filtering.decide(x.tolist(), (0.0,) * m, (0.0,) * m, (0.0,) * m, level_j, 0.0, start=True)
        rows = many.rows(x[:, None], np.zeros((1, m)), np.ones((1, m)), passive=True)
        kept = rows.G[0, -1] @ np.array(decision.u) - rows.d[0, -1]

        assert kept == pytest.approx((decision.power_margin + spendable) / np.linalg.norm(x[2:]), rel=1e-6)


@pytest.mark.parametrize("norm", [None, 2.5])
@pytest.mark.parametrize("m", [1, 2, 3])
def test_no_input_has_a_larger_margin(m: int, norm: float | None) -> None:
    rng = np.random.default_rng(m)
    G = rng.normal(size=(40, 5, m))
    rows = StateRows(G=G / np.linalg.norm(G, axis=2, keepdims=True), d=rng.normal(size=(40, 5)) * 2)
    limits = Limits.of(m, 2.0, norm, None)
    u, t = largest_margin_inputs(rows, limits)

    assert (np.abs(u) <= 2.0).all()
    assert norm is None or (np.linalg.norm(u, axis=1) <= norm * (1 + 1e-12)).all()
    assert rows.margin(u) == pytest.approx(t, abs=1e-4)
    for _ in range(300):
        other = rng.uniform(-2.0, 2.0, (40, m))
        if norm is not None:
            other *= np.minimum(1.0, norm / np.linalg.norm(other, axis=1, keepdims=True))
        assert (rows.margin(other) <= t + 1e-6).all()


def test_a_moving_barrier_is_where_it_is_at_that_time() -> None:
    scenario = load_scenario("moving-disk")
    design = design_of(scenario, robot_of(scenario))
    at_centre = np.zeros((4, 1))

    h_then, _ = BatchRows(design, 1.0).barriers(at_centre)
    h_now, _ = BatchRows(design, 0.0).barriers(at_centre)

    assert (h_now[0], h_then[0]) == pytest.approx((-0.25, 1.5**2 - 0.25))


def test_the_least_neighbourhood_is_the_filter_s() -> None:
    assert BatchRows(mass(((1.0,), 0.0)), 0.0).least_trust == pytest.approx([5e-3])
