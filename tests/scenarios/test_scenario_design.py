import casadi as ca
import pytest

from passafe import Cubic, DesignError, Law, Linear, Mode, Piecewise, SafetyPassivityFilter
from services.scenarios.design import barriers_of, design_of, robot_of, sampled_plant_of, storage_of, tank_of
from services.scenarios.errors import ScenarioError
from services.scenarios.load import load_scenario

NAME = "notomista-cai-2020"


def test_the_reference_scenario_becomes_the_papers_example() -> None:
    scenario = load_scenario(NAME)
    robot = robot_of(scenario)
    design = design_of(scenario, robot)
    [disk] = design.barriers

    assert disk.class_k == (Linear(gain=10.0), Linear(gain=10.0), Cubic(gain=100.0))
    assert design.passivity.class_k == Piecewise(gain=100.0, gain_below=1000.0)
    assert (design.k_i, design.dt_s, design.law, design.mode) == (100.0, 1e-3, Law.SAMPLED, Mode.BOTH)
    assert robot.fail_safe_gain == 9.0
    h = ca.Function("h", [robot.system.x], [disk.h])
    assert float(h([3.0, 4.0, 0.0, 0.0])) == 24.0
    assert sampled_plant_of(scenario, robot).exact


@pytest.mark.parametrize(("kind", "expected"), [("power", None), ("tank", 5.0)])
def test_the_row_draws_on_the_tank_only_where_the_scenario_says_so(kind: str, expected: float | None) -> None:
    scenario = load_scenario(NAME, {"filter.passivity.kind": kind})
    tank = design_of(scenario, robot_of(scenario)).passivity.tank

    assert (None if tank is None else tank.rate_per_s) == expected
    assert tank_of(scenario).initial_j == 1.0


def test_storage_may_be_kinetic() -> None:
    scenario = load_scenario(NAME, {"filter.passivity.storage": "kinetic"})
    robot = robot_of(scenario)
    V = ca.Function("V", [robot.system.x], [storage_of(scenario, robot)])

    assert float(V([7.0, 7.0, 3.0, 4.0])) == 12.5


def test_a_half_plane_keeps_one_side() -> None:
    wall = {
        "kind": "half-plane",
        "name": "wall",
        "normal": [0.0, 1.0],
        "offset": -2.0,
        "class_k": [{"kind": "linear", "gain": 1.0}] * 3,
    }
    scenario = load_scenario(NAME, {"filter.barriers": [wall]})
    robot = robot_of(scenario)
    [barrier] = barriers_of(scenario, robot)

    assert float(ca.Function("h", [robot.system.x], [barrier.h])([0.0, -3.0, 0.0, 0.0])) == -1.0


def test_the_drag_point_is_not_linear() -> None:
    scenario = load_scenario(
        NAME, {"plant.model": "drag-point", "plant.parameters": {"sigma": 1.0, "drag": 0.3}, "duration_s": 1.0}
    )
    robot = robot_of(scenario)

    assert not sampled_plant_of(scenario, robot).exact
    assert SafetyPassivityFilter(design_of(scenario, robot)).row_names[:2] == ("disk", "passivity")


def test_parameters_and_states_that_do_not_fit_the_model_are_named() -> None:
    with pytest.raises(ScenarioError, match=r"plant\.parameters"):
        robot_of(load_scenario(NAME, {"plant.parameters": {"mass": 1.0}}))
    with pytest.raises(ScenarioError, match=r"plant\.x0"):
        robot_of(load_scenario(NAME, {"plant.x0": [1.0]}))
    with pytest.raises(DesignError, match="sigma"):
        robot_of(load_scenario(NAME, {"plant.parameters": {"sigma": -1.0}}))
