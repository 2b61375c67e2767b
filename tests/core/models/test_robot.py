"""A robot of one's own: parts that are optional, and what is refused, in one line."""

from math import inf, nan
from typing import Any

import casadi as ca
import pytest

from passafe import Drawing, FailSafeScope, Parameter, Robot, System, TaskFrame
from passafe.errors import DesignError, ShapeError

X, U, W = ca.SX.sym("x", 2), ca.SX.sym("u", 1), ca.SX.sym("w", 2)
CART = System(x=X, u=U, f=ca.vertcat(X[1], U), y=X[1])


def cart(**parts: Any) -> Robot:  # noqa: ANN401 - parts of every kind
    return Robot(**{"system": CART, "position": X[0], "fail_safe": -X[1]} | parts)


def value(expression: ca.SX, x: tuple[float, float]) -> list[float]:
    return list(ca.Function("value", [X], [expression])(x).full().ravel())


def test_velocity_is_the_rate_of_the_position_if_not_given() -> None:
    assert value(cart(position=X[0] ** 2).velocity, (3.0, 2.0)) == [12.0]


def test_robot_whose_speed_is_its_input_has_no_velocity() -> None:
    robot = cart(position=X[1])

    assert robot.velocity.numel() == 0
    assert value(robot.proportional_derivative(k_p=2.0, k_d=0.0), (0.0, 3.0)) == [-6.0]
    with pytest.raises(DesignError, match=r"k_d: got 1\.0, allowed 0 for a robot without a velocity"):
        robot.proportional_derivative(k_p=0.0, k_d=1.0)


def test_parameters_symbol_outside_of_the_dynamics_is_named() -> None:
    drag = Parameter.of("drag", 1.0)
    system = System(x=X, u=U, f=ca.vertcat(X[1], U - drag.symbol * X[1]), y=X[1], parameters=(drag,))

    with pytest.raises(DesignError, match="of 'drag' take the parameter's value"):
        cart(system=system, fail_safe=-drag.symbol * X[1])


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"dt_s": -1.0}, "fail-safe scope dt_s: got -1.0"),
        ({"kept_gains": ()}, "fail-safe scope kept_gains: got no numbers"),
        ({"kept_gains": (nan,)}, "fail-safe scope kept_gains: got nan"),
        ({"kept_gains": "1"}, "fail-safe scope kept_gains: got '1'"),
        ({"top_speed": "fast"}, "fail-safe scope top_speed: got 'fast'"),
        ({"top_speed": -1.0}, "fail-safe scope top_speed: got -1.0"),
    ],
)
def test_scope_refuses_what_nothing_is_held_against(parts: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError, match=words):
        FailSafeScope(**{"kept_gains": (1.0,)} | parts)


def test_parts_may_be_numbers_or_sequences() -> None:
    robot = cart(fail_safe=0.0, feedback=[0], storage=X[1] ** 2 / 2, barriers={"wall": [1 - X[0]]})

    assert value(robot.fail_safe, (1.0, 1.0)) == [0.0]
    assert robot.feedback is not None
    assert value(robot.barriers["wall"], (0.25, 0.0)) == [0.75]


def test_robot_says_of_its_fail_safe_that_nothing_is_stated() -> None:
    robot = cart()

    assert robot.fail_safe_scope == FailSafeScope(kept_gains=(0.0,))
    assert "not stated" in robot.fail_safe_condition


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"system": 3}, "robot system: got 3 (int), allowed a passafe.System"),
        ({"position": ca.SX(0, 1)}, "robot position: got 0 rows"),
        ({"points": 1}, "robot position: got 1 rows, allowed two for each of 1 points"),
        ({"points": "1"}, "robot points: got '1' .* allowed a whole number from 0 to 32"),
        ({"points": 0.5}, "robot points: got 0.5"),
        ({"velocity": X}, r"system velocity: got shape \(2, 1\)"),
        ({"fail_safe_gain": inf}, "robot fail_safe_gain: got inf"),
        ({"fail_safe_scope": 1.0}, "robot fail_safe_scope: got 1.0 .* allowed a passafe.FailSafeScope"),
        ({"fail_safe_condition": 3}, "robot fail_safe_condition: got 3 .* allowed text"),
        ({"stopping_hull": 3}, "robot stopping_hull: got 3 .* allowed a sequence of positions"),
        ({"stopping_hull": (X,)}, "system stopping_hull: got shape"),
        ({"power_bounds": 1}, "robot power_bounds: got 1 .* allowed a passafe.DerivativeBounds, or None"),
        ({"spheres": (1,)}, "robot spheres: got 1 .* allowed a sequence of spheres"),
        ({"input_unit": 3}, "robot input_unit: got 3 .* allowed text"),
        ({"input_unit": "N" * 201}, "robot input_unit: got 201 characters, allowed at most 200"),
        ({"state_units": 5}, "robot state_units: got 5 .* allowed a sequence of 2 words"),
        ({"state_units": ("m", 3)}, "robot state_units: got 3 .* allowed text"),
        (
            {"barriers": {"wall\n": X[0]}},
            "robot barriers: got 'wall.*' .str., allowed printable characters in one line",
        ),
        ({"barriers": {"": X[0]}}, "robot barriers: got no characters, allowed a name of 1 to 200 characters"),
        ({"barriers": {3: X[0]}}, "robot barriers: got 3 .* allowed text"),
        ({"fail_safe": X}, r"system fail_safe: got shape \(2, 1\)"),
        ({"feedback": U}, "system feedback: got the symbols"),
        ({"storage": X}, "system storage: got shape"),
        ({"barriers": [X[0]]}, "robot barriers: got .* allowed h by name, a dict"),
        ({"barriers": {"wall": X}}, "system barrier 'wall': got shape"),
        ({"state_units": ("m",)}, "robot state_units: got 1 words, allowed 2"),
        ({"task": 1}, "robot task: got 1 .* allowed a passafe.TaskFrame"),
        ({"task": TaskFrame(command=W, u_h=W)}, "system task u_h: got shape"),
        ({"task": TaskFrame(command=W, u_h=W[0] + X[1])}, "task u_h: got .* at a command of zero, allowed zero"),
        ({"drawing": 1}, "robot drawing: got 1 .* allowed a passafe.Drawing"),
        ({"drawing": Drawing(points=ca.vertcat(U, U))}, "system drawing points: got the symbols"),
    ],
)
def test_parts_that_do_not_fit_are_refused(parts: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError, match=words.replace("(int)", r"\(int\)")):
        cart(**parts)


def test_commands_are_counted_in_the_task_frame() -> None:
    assert cart().commands == 1
    assert cart(task=TaskFrame(command=W, u_h=W[0] + W[1])).commands == 2


def test_rate_of_a_task_command_follows_the_plant() -> None:
    """For u_h = x₀w₀ + w₁: u̇_h = x₁w₀ + x₀ẇ₀ + ẇ₁."""
    task, rate = TaskFrame(command=W, u_h=X[0] * W[0] + W[1]), ca.SX.sym("rate", 2)
    function = ca.Function("rate", [X, U, W, rate], [task.rate(CART, rate)])

    assert float(function([2.0, 3.0], 7.0, [5.0, 1.0], [0.1, 0.01])) == pytest.approx(3.0 * 5.0 + 2.0 * 0.1 + 0.01)


def test_task_refuses_a_command_that_is_no_symbol() -> None:
    with pytest.raises(ShapeError, match="task command"):
        TaskFrame(command=W * 2, u_h=W)
    with pytest.raises(DesignError, match="task axes: got 1 words, allowed 2"):
        TaskFrame(command=W, u_h=W, axes=("x",))
    with pytest.raises(DesignError, match=r"task axes: got 2 .* allowed text"):
        TaskFrame(command=W, u_h=W, axes=("x", 2))  # type: ignore[arg-type]  # wrong on purpose


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"dimensions": 4}, "drawing dimensions: got 4 .* allowed 2 or 3"),
        ({"dimensions": "2"}, "drawing dimensions: got '2' .* allowed 2 or 3"),
        ({"points": X[0]}, "drawing points: got shape"),
        ({"heading": X}, "drawing heading: got shape"),
        ({"links": 7}, "drawing links: got 7"),
        ({"links": ((0, 0.5),)}, "drawing links: got"),
        ({"outline": ((0.0, nan),)}, "drawing outline: got .* allowed pairs of finite numbers"),
        ({"radii": (-1.0,)}, "drawing radii: got -1.0"),
        ({"links": ((0, 1),)}, "drawing links: got .* allowed pairs of points from 0 to 0"),
        ({"radii": (0.1, 0.2)}, "drawing radii: got 2 numbers, allowed one for each of 1 points"),
        ({"outline": ((0.0, 0.0),) * 65}, "drawing outline: got 65 entries, allowed at most 64"),
    ],
)
def test_drawing_refuses_what_does_not_fit(parts: dict[str, Any], words: str) -> None:
    with pytest.raises(DesignError, match=words):
        Drawing(**{"points": X} | parts)


def test_drawing_counts_its_points_in_space() -> None:
    assert Drawing(points=ca.vertcat(X, X, X), dimensions=3, links=((0, 1),)).count == 2
