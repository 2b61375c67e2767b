"""Parameters of a system: nominal values in the dynamics, and other members of the family."""

import casadi as ca
import pytest

from passafe.errors import DesignError
from passafe.models.damped_point import damped_point
from passafe.models.drag_point import drag_point
from passafe.models.joint_chain import joint_chain
from passafe.models.lagged_point import lagged_point
from passafe.models.robot import Robot
from passafe.models.saturating_point import saturating_point
from passafe.models.two_points import two_points
from passafe.parameter import Parameter
from passafe.system import System


def rates(system: System, x: list[float], u: list[float]) -> list[float]:
    f = ca.Function("f", [system.x, system.u], [system.f])
    return [float(rate) for rate in f(x, u).full().ravel()]


def output(system: System, x: list[float]) -> list[float]:
    y = ca.Function("y", [system.x], [system.y])
    return [float(value) for value in y(x).full().ravel()]


def test_f_is_nominal_and_general_f_keeps_the_symbols() -> None:
    system = damped_point(sigma=2.0, mass=4.0).system

    assert {str(symbol) for symbol in ca.symvar(system.general_f)} >= {"sigma", "mass"}
    assert rates(system, [0, 0, 1, 3], [8, 4]) == [1, 3, -2 + 2, -6 + 1]


def test_another_member_has_other_values() -> None:
    heavier = damped_point(sigma=2.0).system.with_parameters({"mass": 2.0})

    assert rates(heavier, [0, 0, 1, 3], [8, 4]) == [1, 3, -2 + 4, -6 + 2]
    assert {each.name: each.value for each in heavier.parameters} == {"mass": 2.0, "sigma": 2.0}
    assert rates(heavier.with_parameters({"sigma": 0.0}), [0, 0, 1, 3], [8, 4]) == [1, 3, 4, 2]


def test_parameters_of_output_and_port() -> None:
    x, u, gain = ca.SX.sym("x"), ca.SX.sym("u"), Parameter.of("gain", 3.0)
    system = System(x=x, u=u, f=u, y=gain.symbol * x, parameters=(gain,))

    assert output(system, [2.0]) == output(System(x=x, u=u, f=u, y=system.port_y), [2.0]) == [6.0]
    assert output(system.with_parameters({"gain": 5.0}), [2.0]) == [10.0]


def test_names_that_are_no_parameters_are_refused() -> None:
    with pytest.raises(DesignError, match=r"'weight'.*'mass', 'sigma'"):
        damped_point().system.with_parameters({"weight": 1.0})


def test_a_symbol_that_is_no_parameter_is_refused() -> None:
    x, u, gain = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("gain")
    with pytest.raises(DesignError, match="gain"):
        System(x=x, u=u, f=gain * u, y=x)


@pytest.mark.parametrize("given", [3, ["mass"], [Parameter.of("a", 1.0), Parameter.of("a", 2.0)]])
def test_what_is_no_set_of_parameters_is_refused(given: object) -> None:
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    with pytest.raises(DesignError, match="system parameters"):
        System(x=x, u=u, f=u, y=x, parameters=given)  # type: ignore[arg-type]  # wrong on purpose


def test_what_is_no_parameter_is_refused() -> None:
    symbol = ca.SX.sym("a")
    for name, stands, value in (
        ("", symbol, 1.0),
        ("a", symbol + 1, 1.0),
        ("a", 1.0, 1.0),
        ("a", symbol, float("inf")),
    ):
        with pytest.raises(DesignError, match="parameter"):
            Parameter(name=name, symbol=stands, value=value)


@pytest.mark.parametrize("build", [damped_point, drag_point, saturating_point, lagged_point, two_points])
def test_a_robot_of_two_masses_brakes_as_one_of_one(build: object) -> None:
    """Its fail-safe pushes twice as hard, so that it moves alike."""
    for dt_s in (0.0, 0.01):
        one, two = (_braking(build, mass=mass, dt_s=dt_s) for mass in (1.0, 2.0))
        assert two == pytest.approx(one, abs=1e-12)


def _braking(build: object, *, mass: float, dt_s: float) -> list[float]:
    """Return accelerations under the fail-safe from the same way to move, whatever the mass."""
    assert callable(build)
    # The saturating drive's largest force and the lagged drive's state are forces: as large for each unit of mass.
    more = {"force": 20.0 * mass} if build is saturating_point else {}
    robot = build(mass=mass, gamma_1=5.0, dt_s=dt_s, **more)
    assert isinstance(robot, Robot)
    n = robot.system.n
    x = [0.3 + 0.1 * i for i in range(n)]
    if build is lagged_point:
        x[4:] = [mass * force for force in x[4:]]
    u = ca.Function("u", [robot.system.x], [robot.fail_safe])(x).full().ravel().tolist()
    return rates(robot.system, x, u)[: n if build is not lagged_point else 4]


def test_a_joint_chain_has_parameters_too() -> None:
    assert [each.name for each in joint_chain(joints=2).system.parameters] == ["mass", "sigma"]
