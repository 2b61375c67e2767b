"""Values of a scenario's barriers at one measured state after another, from the h that the filter is derived from."""

from collections.abc import Sequence

import casadi as ca
from passafe_services.scenarios.design import barriers_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.uncertain_robot import reading_error_of
from passafe_services.tools.review.rounding_error import rounding_error

from passafe.numerics.workspace import BlockLayout, Workspace, dense_function
from passafe_dashboard.columns import moving_table


class BarrierValues:
    """Evaluates h and the displacement of every barrier, compiled once.

    Args:
        scenario: The scenario.

    Raises:
        ScenarioError: Its model does not take its parameters or its x0.
        DesignError: A barrier or a parameter that the robot cannot have.

    Attributes:
        is_exact: Whether the scenario says of no state that it is read with an error.
    """

    def __init__(self, scenario: Scenario) -> None:
        robot = robot_of(scenario)
        x, t = robot.system.x, robot.system.t
        barriers = barriers_of(scenario, robot)
        outlines = enumerate(barrier.outline for barrier in scenario.barriers)
        motions = {moving_table(i): one.motion for i, one in outlines if one is not None and one.motion is not None}
        self._moving = tuple(motions)
        shapes: dict[str, int | tuple[int, ...]] = {
            "x": x.numel(),
            "t": 1,
            "h": len(barriers),
            "possible": len(barriers),
            "d": (2, len(motions)),
        }
        self._space = Workspace(BlockLayout.of(shapes))
        h = ca.vertcat(ca.SX(0, 1), *(barrier.h for barrier in barriers))
        self._evaluate_h = self._space.bind(dense_function("h", [x, t], [h]), ["x", "t"], ["h"])
        reading_error = reading_error_of(scenario, robot)
        self.is_exact = not any(reading_error)
        error = 0 if self.is_exact else rounding_error(h, ca.vertcat(x, t), ca.SX([*reading_error, 0.0]))
        possible = dense_function("possible", [x, t], [h + error])
        self._evaluate_possible = self._space.bind(possible, ["x", "t"], ["possible"])
        d = ca.vertcat(ca.SX(0, 1), *(motion.displacement(t) for motion in motions.values()))
        self._evaluate_d = self._space.bind(dense_function("d", [t], [d]), ["t"], ["d"])
        self._x, self._t = self._space.part("x"), self._space.part("t")
        self._h, self._possible, self._d = self._space.part("h"), self._space.part("possible"), self._space.view("d")

    def h(self, x: Sequence[float], t_s: float) -> list[float]:
        """Return h of every barrier in the scenario's order.

        Args:
            x: State that begins with the scenario's, n numbers or more.
            t_s: Plant time, s.
        """
        self._write(x, t_s)
        self._evaluate_h()
        values: list[float] = self._h.tolist()
        return values

    def possible_h(self, x: Sequence[float], t_s: float) -> list[float]:
        """Return h of every barrier with the error added that it may have by how the state was read.

        Args:
            x: State as it was read, that begins with the scenario's, n numbers or more.
            t_s: Plant time, s.
        """
        self._write(x, t_s)
        self._evaluate_possible()
        values: list[float] = self._possible.tolist()
        return values

    def displacements_m(self, t_s: float) -> dict[str, tuple[float, float]]:
        """Return the displacement of every outline that moves from where it was drawn, m, by the name of its table.

        Args:
            t_s: Plant time, s.
        """
        self._t[0] = t_s
        self._evaluate_d()
        return dict(zip(self._moving, zip(*self._d.tolist(), strict=True), strict=True))

    def _write(self, x: Sequence[float], t_s: float) -> None:
        self._x[:] = x[: len(self._x)]
        self._t[0] = t_s
