"""Robot as known to the person who steers it: linear response to u_h at rest, without the filter."""

from dataclasses import dataclass
from typing import Final, Self

import casadi as ca
import numpy as np

from passafe_services.operator.errors import SourceConfigError
from passafe_services.scenarios.design import feedback_of, robot_of
from passafe_services.scenarios.schema import Scenario

SAME: Final = 1e-6
"""Tolerance for equal slopes, 1/s or 1/s²."""


@dataclass(frozen=True, kw_only=True, slots=True)
class SteeredRobot:
    """p̈ = −aṗ − kp + u_h in every coordinate.

    Attributes:
        axes: Number of coordinates, and of inputs.
        damping_per_s: a, of the robot and its feedback together, 1/s.
        stiffness_per_s2: k, 1/s².
    """

    axes: int
    damping_per_s: float
    stiffness_per_s2: float

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Return the scenario's robot under its feedback u = u_fb(x) + u_h, linearized at rest in the origin.

        Raises:
            SourceConfigError: The force does not act at once, or the coordinates differ.
        """
        robot = robot_of(scenario)
        system, k = robot.system, robot.system.m
        u_h = ca.SX.sym("u_h", k)
        u = feedback_of(scenario, robot) + u_h
        if system.n != 2 * k or robot.task is not None:
            raise _not_steerable(scenario)
        acceleration = ca.substitute(system.f[k:], system.u, u)
        slopes = ca.Function("slopes", [system.x, u_h], [ca.jacobian(acceleration, ca.vertcat(system.x, u_h))])
        at_rest = slopes(ca.DM.zeros(system.n), ca.DM.zeros(k)).full()
        stiffness, damping, gain = (at_rest[:, i * k : (i + 1) * k] for i in range(3))
        wanted = [(stiffness, stiffness[0, 0]), (damping, damping[0, 0]), (gain, 1.0)]
        if not all(np.allclose(slope, value * np.eye(k), rtol=0, atol=SAME) for slope, value in wanted):
            raise _not_steerable(scenario)
        return cls(axes=k, damping_per_s=-float(damping[0, 0]), stiffness_per_s2=-float(stiffness[0, 0]))


def _not_steerable(scenario: Scenario) -> SourceConfigError:
    allowed = "a robot whose force acts without lag and equally in every coordinate"
    return SourceConfigError("kind", f"human with a {scenario.plant.model}", allowed)
