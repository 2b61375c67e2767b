import casadi as ca
import pytest
from passafe_services.scenarios.design import barriers_of, design_of, robot_of, sampled_plant_of, storage_of, tank_of
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.robot_models import ROBOT_MODELS
from passafe_services.scenarios.schema import Scenario

from passafe import Cubic, DesignError, Law, Linear, Mode, Piecewise, SafetyPassivityFilter

NAME = "notomista-cai-2020"


def test_robot_of_its_own_may_have_the_name_of_a_model() -> None:
    car = load_scenario("unicycle-posts").model_dump(mode="json")
    car["plant"]["model"] = "lagged-point"

    assert robot_of(scenario_from(car, "a log")).system.n == 5


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
def test_passivity_row_uses_the_tank_only_if_configured(kind: str, expected: float | None) -> None:
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


def test_parameters_and_states_of_other_models_are_named() -> None:
    with pytest.raises(ScenarioError, match=r"plant\.parameters"):
        robot_of(load_scenario(NAME, {"plant.parameters": {"drag": 1.0}}))
    with pytest.raises(ScenarioError, match=r"plant\.x0"):
        robot_of(load_scenario(NAME, {"plant.x0": [1.0]}))
    with pytest.raises(DesignError, match="sigma"):
        robot_of(load_scenario(NAME, {"plant.parameters": {"sigma": -1.0}}))


CHAIN = [{"kind": "linear", "gain": 2.0}, {"kind": "linear", "gain": 7.0}, {"kind": "linear", "gain": 1.0}]
DISK = {"kind": "disk-keep-out", "name": "disk", "centre": [5, 0], "radius": 1, "class_k": CHAIN}
SPEED = {"kind": "speed-limit", "name": "speed", "limit_m_per_s": 9, "class_k": [{"kind": "linear", "gain": 50.0}] * 2}


def with_plant(model: str, states: int, *barriers: dict[str, object], **parameters: float) -> Scenario:
    plant = {"model": model, "x0": [0.1] * states, "parameters": parameters}
    return load_scenario(NAME, {"plant": plant, "filter.barriers": list(barriers)})


@pytest.mark.parametrize(
    ("model", "states", "inputs", "points"),
    [
        ("damped-point", 4, 2, 1),
        ("drag-point", 4, 2, 1),
        ("lagged-point", 6, 2, 1),
        ("saturating-point", 4, 2, 1),
        ("two-points", 8, 4, 2),
        ("joint-chain", 14, 7, 0),
        ("joint-chain", 2, 1, 0),
    ],
)
def test_every_model_becomes_a_robot(model: str, states: int, inputs: int, points: int) -> None:
    robot = robot_of(with_plant(model, states))

    assert (robot.system.n, robot.system.m, robot.points) == (states, inputs, points)
    assert ROBOT_MODELS[model].points == points


@pytest.mark.parametrize("states", [1, 3, 16])
def test_joints_are_counted_by_their_starts(states: int) -> None:
    with pytest.raises(ScenarioError, match="an angle and a speed for each of 1 to 7 joints"):
        robot_of(with_plant("joint-chain", states))


def test_fail_safe_uses_the_gains_of_the_position_barriers() -> None:
    limits = {"kind": "coordinate-limits", "name": "v", "of": "velocity", "low": [-9] * 2, "high": [9] * 2}
    others = (SPEED, limits | {"class_k": SPEED["class_k"]})

    assert robot_of(with_plant("damped-point", 4, DISK, *others, sigma=0.5)).fail_safe_gain == 1.5
    assert robot_of(with_plant("damped-point", 4, *others, sigma=0.5)).fail_safe_gain == 0.0
    joints = limits | {"of": "position", "low": [-9], "high": [9], "class_k": CHAIN}
    assert robot_of(with_plant("joint-chain", 2, joints, sigma=0.5)).fail_safe_gain == 1.5


def test_a_lagging_robot_s_fail_safe_goes_by_the_second_gain_too() -> None:
    robot = robot_of(with_plant("lagged-point", 6, DISK | {"class_k": [*CHAIN, CHAIN[0]]}, SPEED, sigma=0.5, lag_s=0.5))

    assert "γ₁ ≤ 2/s and γ₁, γ₂ ≤ 7/s" in robot.fail_safe_condition


def test_limits_of_a_coordinate_that_is_not_there_are_refused() -> None:
    joints = {"kind": "coordinate-limits", "name": "joint", "low": [-1] * 3, "high": [1] * 3, "class_k": CHAIN}
    scenario = with_plant("joint-chain", 4, joints)

    with pytest.raises(DesignError, match="barrier 'joint 3 low': got position coordinate 3, allowed 1 to 2"):
        barriers_of(scenario, robot_of(scenario))


def test_storage_may_be_a_spring_s() -> None:
    scenario = load_scenario(
        NAME, {"filter.passivity.storage": "spring", "filter.passivity.spring_stiffness_per_s2": 3.0}
    )
    robot = robot_of(scenario)
    V = ca.Function("V", [robot.system.x], [storage_of(scenario, robot)])

    assert float(V([1.0, 2.0, 3.0, 4.0])) == 12.5 + 1.5 * 5
