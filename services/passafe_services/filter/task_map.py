"""Map of the operator's commands from the robot's task frame to the plant's input, at a state."""

from typing import Protocol

import casadi as ca
from passafe_protocol.messages import Vector

from passafe.models.robot import Robot
from passafe.models.task_frame import TaskFrame
from passafe.numerics.workspace import BlockLayout, Workspace, dense_function


class CommandMap(Protocol):
    """Map from a request to the input that is asked for."""

    def inputs(self, x: Vector, u: Vector, command: Vector, command_rate: Vector) -> tuple[Vector, Vector]:
        """Return u_h and its rate, m numbers each.

        Args:
            x: State at which the input takes effect.
            u: Input in force until then.
            command: Coordinates of the command.
            command_rate: Their rate, per second.
        """
        ...


class PlainCommand:
    """A command that is the input itself."""

    def inputs(self, x: Vector, u: Vector, command: Vector, command_rate: Vector) -> tuple[Vector, Vector]:
        """Return the command and its rate."""
        del x, u
        return command, command_rate


class TaskCommand:
    """A command in a task frame: u_h = T(x, w), u̇_h = (∂T/∂x) f(x, u) + (∂T/∂w) ẇ."""

    def __init__(self, robot: Robot, task: TaskFrame) -> None:
        """Compile the map.

        Args:
            robot: The robot.
            task: Its task frame.
        """
        system, k = robot.system, task.size
        rate = ca.SX.sym("command_rate", k)
        self._space = Workspace(
            BlockLayout.of(
                {"x": system.n, "u": system.m, "command": k, "command_rate": k, "u_h": system.m, "u_h_rate": system.m}
            )
        )
        function = dense_function(
            "task_command", [system.x, system.u, task.command, rate], [task.u_h, task.rate(system, rate)]
        )
        self._evaluate = self._space.bind(function, ["x", "u", "command", "command_rate"], ["u_h", "u_h_rate"])
        self._write_x, self._write_u, self._write_command, self._write_rate = (
            self._space.writer(name) for name in ("x", "u", "command", "command_rate")
        )
        self._read_u_h, self._read_rate = self._space.reader("u_h"), self._space.reader("u_h_rate")

    def inputs(self, x: Vector, u: Vector, command: Vector, command_rate: Vector) -> tuple[Vector, Vector]:
        """Return u_h and its rate at the state; see ``CommandMap``."""
        self._write_x(*x)
        self._write_u(*u)
        self._write_command(*command)
        self._write_rate(*command_rate)
        self._evaluate()
        return self._read_u_h(), self._read_rate()


def command_map(robot: Robot) -> CommandMap:
    """Return the map of a robot's commands."""
    return PlainCommand() if robot.task is None else TaskCommand(robot, robot.task)
