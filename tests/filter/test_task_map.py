"""Commands in a task frame, at the state at which they take effect."""

from math import cos, sin

import pytest
from passafe_services.filter.task_map import PlainCommand, command_map

from passafe.models.damped_point import damped_point
from passafe.models.unicycle import unicycle


def test_command_of_a_robot_without_a_frame_is_the_input() -> None:
    commands = command_map(damped_point())

    assert isinstance(commands, PlainCommand)
    assert commands.inputs((0.0,) * 4, (0.0,) * 2, (1.0, 2.0), (3.0, 4.0)) == ((1.0, 2.0), (3.0, 4.0))


def test_command_in_the_world_turns_with_the_heading() -> None:
    """u_h = (w₁c + w₂s, (w₂c − w₁s)/ℓ); with ẇ = 0 it changes as the car turns."""
    commands, (theta, turn) = command_map(unicycle(nose_m=0.5)), (0.7, 2.0)
    c, s = cos(theta), sin(theta)

    u_h, rate = commands.inputs((1.0, 2.0, theta, 0.3, turn), (0.0, 0.0), (2.0, 1.0), (0.0, 0.0))

    assert u_h == pytest.approx((2 * c + s, (c - 2 * s) / 0.5))
    assert rate == pytest.approx((turn * (c - 2 * s), turn * (-s - 2 * c) / 0.5))


def test_command_of_zero_asks_for_nothing() -> None:
    commands = command_map(unicycle())

    assert commands.inputs((1.0, 2.0, 0.7, 0.3, 2.0), (5.0, 6.0), (0.0, 0.0), (0.0, 0.0)) == ((0.0, 0.0), (0.0, 0.0))
