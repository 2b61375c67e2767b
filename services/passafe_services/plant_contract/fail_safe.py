"""What decides the plant's input where no other follows: the last one for a while, then the model's own law."""

from struct import Struct
from typing import Final

import casadi as ca
from passafe_protocol.messages import PlantPhase, Vector

from passafe.limits import Limits
from passafe.models.robot import Robot
from passafe.workspace import BlockLayout, Workspace, dense_function

HOLDING: Final = PlantPhase.HOLDING
FAIL_SAFE: Final = PlantPhase.FAIL_SAFE


class FailSafe:
    """The plant's rule for missing inputs. The filter predicts with the same object's class, so they cannot disagree.

    An input is in force for at most ``hold_ns`` in all, and for one period at least; the filter's margin ε covers
    that time (``docs/theory.md``, section 6), and the law that follows keeps what its model says (section 10).
    """

    def __init__(self, robot: Robot, limits: Limits, *, period_ns: int, hold_ns: int) -> None:
        """Compile the law.

        Args:
            robot: Its ``fail_safe`` is the law.
            limits: What the actuators can do; the law is put within its magnitudes and its norm.
            period_ns: Period of the plant, ns.
            hold_ns: Longest time for which any input may be in force, ns.
        """
        system = robot.system
        self._space = Workspace(BlockLayout.of({"x": system.n, "u": system.m}))
        bound = ca.DM(list(limits.magnitude))
        clipped = limits.clip(robot.fail_safe, ca.DM.zeros(system.m), -bound, bound)
        self._evaluate = self._space.bind(dense_function("fail_safe", [system.x], [clipped]), ["x"], ["u"])
        self._give = Struct(f"{system.m}d").unpack_from
        self._offset = system.n * 8
        self._period_ns = period_ns
        self._hold_ns = hold_ns

    def law(self, x: Vector) -> Vector:
        """Return the fail-safe law's input at a state, within the limits, m numbers."""
        self._space.part("x")[:] = x
        self._evaluate()
        return self._give(self._space.memory, self._offset)

    def without_input(
        self, u: Vector, input_since_ns: int, now_ns: int, x: Vector, hold_ns: int | None = None
    ) -> tuple[PlantPhase, Vector]:
        """Return what is in force for the coming period if no input is due.

        Args:
            u: What was in force until now.
            input_since_ns: Plant time from which the last input has been in force.
            now_ns: Plant time.
            x: State now.
            hold_ns: How long that input may be in force, if it says so itself.
        """
        longest_ns = self._hold_ns if hold_ns is None or hold_ns > self._hold_ns else hold_ns
        if now_ns - input_since_ns + self._period_ns <= longest_ns:
            return HOLDING, u
        return FAIL_SAFE, self.law(x)
