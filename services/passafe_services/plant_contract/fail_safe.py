"""Fail-safe rule for missing inputs: hold the last input for a limited time, then apply the model's fail-safe law."""

from typing import Final

import casadi as ca
from passafe_protocol.messages import PlantPhase, Vector

from passafe.limits import Limits
from passafe.models.robot import Robot
from passafe.numerics.workspace import BlockLayout, Workspace, dense_function

HOLDING: Final = PlantPhase.HOLDING
FAIL_SAFE: Final = PlantPhase.FAIL_SAFE


class FailSafe:
    """Rule of the plant for missing inputs; the filter predicts with the same class, so both always agree.

    An input is in force for at most ``hold_ns`` in total, and for at least one period; the filter's margin ε covers
    that time (``docs/theory.md``, section 6). The law that follows has the properties of its model (section 10).

    Attributes:
        hold_ns: Longest time for which any input may be in force, ns.
    """

    def __init__(self, robot: Robot, limits: Limits, *, period_ns: int, hold_ns: int) -> None:
        """Compile the law.

        Args:
            robot: Provides the law, ``fail_safe``.
            limits: Input limits; the law is clipped to all but the rates.
            period_ns: Period of the plant, ns.
            hold_ns: Longest time for which any input may be in force, ns.
        """
        system = robot.system
        self._space = Workspace(BlockLayout.of({"x": system.n, "u": system.m}))
        centre, low, high = (ca.DM(list(each)) for each in (limits.centre, limits.low, limits.high))
        clipped = limits.clip(robot.fail_safe, centre, low, high)
        self._evaluate = self._space.bind(dense_function("fail_safe", [system.x], [clipped]), ["x"], ["u"])
        self._write_x, self._read_u = self._space.writer("x"), self._space.reader("u")
        self._period_ns = period_ns
        self.hold_ns = hold_ns

    def law(self, x: Vector) -> Vector:
        """Return the fail-safe law's input at a state, within the limits, m numbers."""
        self._write_x(*x)
        self._evaluate()
        return self._read_u()

    def without_input(
        self, u: Vector, input_since_ns: int, now_ns: int, x: Vector, hold_ns: int | None = None
    ) -> tuple[PlantPhase, Vector]:
        """Return phase and input of the coming period if no input is due.

        Args:
            u: Input in force until now.
            input_since_ns: Plant time at which the last input took effect, ns.
            now_ns: Plant time, ns.
            x: State now.
            hold_ns: Longest time for which that input may be in force, if its message limits it, ns.
        """
        longest_ns = self.hold_ns if hold_ns is None or hold_ns > self.hold_ns else hold_ns
        if now_ns - input_since_ns + self._period_ns <= longest_ns:
            return HOLDING, u
        return FAIL_SAFE, self.law(x)
