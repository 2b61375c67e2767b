"""A robot model: its dynamics, the quantities for barriers and feedback, and its fail-safe law."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import casadi as ca
import numpy as np

from passafe.arguments import described
from passafe.derivative_bounds import DerivativeBounds
from passafe.errors import DesignError, ShapeError
from passafe.expressions import as_column
from passafe.models.body_sphere import BodySphere
from passafe.models.drawing import Drawing
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.task_frame import TaskFrame
from passafe.system import System

_NOTHING: Final = 1e-9
"""Largest input that a command of zero may lead to: rounding."""

_KEEPS_NONE: Final = FailSafeScope(kept_gains=(0.0,))

NOT_STATED: Final = "not stated: which barriers the law keeps is for the robot's maker to say"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Robot:
    """A plant with the quantities that barriers and feedback are written in, and its own fail-safe.

    Each expression may also be given as numbers or as a sequence of scalars, which makes a column.

    Attributes:
        system: The dynamics.
        position: Expression of x, shape (k, 1), m; rad for joints.
        velocity: Expression of x, shape (k, 1), m/s; rad/s for joints. The rate of the position if it is not given,
            which then must not depend on the input.
        points: How many points in the plane the position is made of; 0 where it is no place, as with joints.
        fail_safe: Law u(x) that the robot applies when no input comes, shape (m, 1).
        fail_safe_gain: K, by which that law multiplies −velocity, 1/s or equivalent.
        fail_safe_scope: The barriers that law keeps, in numbers; none if not given.
        stopping_hull: Positions as expressions of x, each of shape (k, 1). While that law is in force the position
            never leaves their convex hull, under ``fail_safe_condition``.
        fail_safe_condition: The condition under which that law keeps a barrier, in words.
        feedback: The robot's own state feedback u_fb, expression of x, shape (m, 1), or none.
        storage: Its own storage function V, scalar expression of x, J, or none.
        power_bounds: Bounds of the first two derivatives of the power margin with that storage, or none.
        spheres: Spheres that cover its body, in space.
        barriers: Its own barriers: h by name, scalar expressions of x and t.
        task: The frame in which it is commanded, if that is not the input's own.
        drawing: How it is drawn; at its points, or as coordinates, if that is not given.
        input_unit: Unit of u, in words.
        state_units: Unit of each state, n words, for tables; none if not given.
    """

    system: System
    position: ca.SX
    velocity: ca.SX = field(default_factory=lambda: ca.SX(0, 0))
    points: int = 0
    fail_safe: ca.SX
    fail_safe_gain: float = 0.0
    fail_safe_scope: FailSafeScope = _KEEPS_NONE
    stopping_hull: tuple[ca.SX, ...] = ()
    fail_safe_condition: str = NOT_STATED
    feedback: ca.SX | None = None
    storage: ca.SX | None = None
    power_bounds: DerivativeBounds | None = None
    spheres: tuple[BodySphere, ...] = ()
    barriers: Mapping[str, ca.SX] = field(default_factory=dict)
    task: TaskFrame | None = None
    drawing: Drawing | None = None
    input_unit: str = ""
    state_units: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse parts that do not fit the system."""
        if not isinstance(self.system, System):
            raise DesignError("robot system", described(self.system), "a passafe.System")
        self._take("position", self.position)
        rows = int(self.position.numel())
        if rows == 0 or rows < 2 * self.points:
            raise ShapeError("robot position", f"{rows} rows", f"two for each of {self.points} points, at least one")
        self._take_velocity(rows)
        self._take("fail_safe", self.fail_safe, self.system.m)
        if self.feedback is not None:
            self._take("feedback", self.feedback, self.system.m)
        if self.storage is not None:
            self._take("storage", self.storage, 1)
        if not isinstance(self.barriers, Mapping):
            raise DesignError("robot barriers", described(self.barriers), "h by name, a dict")
        own = {name: as_column(f"robot barrier {name!r}", h) for name, h in self.barriers.items()}
        for name, h in own.items():
            self.system.require_state_function(f"barrier {name!r}", h, 1, may_move=True)
        object.__setattr__(self, "barriers", own)
        if self.state_units and len(self.state_units) != self.system.n:
            got = f"{len(self.state_units)} words"
            raise DesignError("robot state_units", got, f"{self.system.n}, one for each state, or none")
        self._check_task()
        self._check_drawing()

    def _take(self, part: str, value: object, rows: int | None = None) -> None:
        expression = as_column(f"robot {part}", value)
        self.system.require_state_function(part, expression, int(expression.numel()) if rows is None else rows)
        object.__setattr__(self, part, expression)

    def _take_velocity(self, rows: int) -> None:
        velocity = as_column("robot velocity", self.velocity)
        if velocity.shape == (0, 0):
            velocity = self.system.lie_derivative(self.position)
            if ca.depends_on(velocity, self.system.u):
                raise DesignError("robot velocity", "none, and the rate of the position depends on u", "one given")
        self._take("velocity", velocity, rows)

    def _check_task(self) -> None:
        if self.task is None:
            return
        if not isinstance(self.task, TaskFrame):
            raise DesignError("robot task", described(self.task), "a passafe.TaskFrame")
        free = ca.substitute(self.task.u_h, self.task.command, ca.SX.zeros(self.task.size))
        self.system.require_state_function("task u_h", free, self.system.m)
        at_rest = ca.Function("at_rest", [self.system.x], [free])
        samples = np.random.default_rng(1)
        asked = max(float(ca.norm_inf(at_rest(x))) for x in samples.normal(size=(8, self.system.n)))
        if not asked <= _NOTHING:
            allowed = "zero there, as who lets go asks for nothing; write what remains as feedback"
            raise DesignError("task u_h", f"{asked:.3g} at a command of zero", allowed)

    def _check_drawing(self) -> None:
        if self.drawing is None:
            return
        if not isinstance(self.drawing, Drawing):
            raise DesignError("robot drawing", described(self.drawing), "a passafe.Drawing")
        for part, rows in (("points", int(self.drawing.points.numel())), ("heading", 1)):
            self.system.require_state_function(f"drawing {part}", getattr(self.drawing, part), rows)

    @property
    def commands(self) -> int:
        """Return the number of coordinates of a command: those of the task frame, or of the input."""
        return self.system.m if self.task is None else self.task.size

    def proportional_derivative(self, *, k_p: float, k_d: float) -> ca.SX:
        """Return u_fb = −k_p·position − k_d·velocity, for robots with one input for each coordinate."""
        return -k_p * self.position - k_d * self.velocity
