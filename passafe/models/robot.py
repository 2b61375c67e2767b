"""A robot model: its dynamics, the quantities for barriers and feedback, and its fail-safe law."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import casadi as ca
import numpy as np

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described, members
from passafe.arguments.ranges import require_finite
from passafe.enclosures.derivative_bounds import DerivativeBounds
from passafe.errors import DesignError, ShapeError
from passafe.models.body_sphere import BodySphere
from passafe.models.drawing import Drawing
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.robot_parts import LONGEST_TEXT, count, kind_or_none, kinds, name, text, texts
from passafe.models.task_frame import TaskFrame
from passafe.system import System

_NOTHING: Final = 1e-9
"""Largest input that a command of zero may lead to: rounding."""

_KEEPS_NONE: Final = FailSafeScope(kept_gains=(0.0,))

MOST_POINTS: Final = 32
"""Points in the plane that one robot may move."""

NOT_STATED: Final = "not stated: which barriers the law keeps is for the robot's maker to say"


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Robot:
    """A plant with the quantities that barriers and feedback are written in, and its own fail-safe.

    Each expression may also be given as numbers or as a sequence of scalars, which makes a column.

    Attributes:
        system: The dynamics.
        position: Expression of x, shape (k, 1), m; rad for joints.
        velocity: Expression of x, shape (k, 1), m/s; rad/s for joints. The rate of the position if it is not given; of
            shape (0, 1) where that depends on the input, as for a robot whose speed is commanded: it has none.
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
        object.__setattr__(self, "points", count("robot points", self.points, MOST_POINTS))
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
        self._take_barriers()
        self._take_fail_safe_terms(rows)
        kind_or_none("robot power_bounds", self.power_bounds, DerivativeBounds)
        spheres = kinds("robot spheres", self.spheres, BodySphere, "a sequence of spheres of the body")
        object.__setattr__(self, "spheres", spheres)
        text("robot input_unit", self.input_unit)
        object.__setattr__(self, "state_units", texts("robot state_units", self.state_units, self.system.n))
        self._check_task()
        self._check_drawing()

    def _take_barriers(self) -> None:
        if not isinstance(self.barriers, Mapping):
            raise DesignError("robot barriers", described(self.barriers), "h by name, a dict")
        own = {
            name("robot barriers", each): as_column(f"robot barrier {each!r}", h) for each, h in self.barriers.items()
        }
        for each, h in own.items():
            self.system.require_state_function(f"barrier {each!r}", h, 1, may_move=True)
        object.__setattr__(self, "barriers", own)

    def _take_fail_safe_terms(self, rows: int) -> None:
        """Refuse what is said of the fail-safe law in no words or numbers that it can be held against."""
        require_finite("robot fail_safe_gain", self.fail_safe_gain, "1/s")
        if not isinstance(self.fail_safe_scope, FailSafeScope):
            raise DesignError("robot fail_safe_scope", described(self.fail_safe_scope), "a passafe.FailSafeScope")
        text("robot fail_safe_condition", self.fail_safe_condition, LONGEST_TEXT)
        corners = members(self.stopping_hull)
        if corners is None:
            raise DesignError("robot stopping_hull", described(self.stopping_hull), "a sequence of positions")
        hull = tuple(as_column("robot stopping_hull", corner) for corner in corners)
        for corner in hull:
            self.system.require_state_function("stopping_hull", corner, rows)
        object.__setattr__(self, "stopping_hull", hull)

    def _take(self, part: str, value: object, rows: int | None = None) -> None:
        expression = as_column(f"robot {part}", value)
        self.system.require_state_function(part, expression, int(expression.numel()) if rows is None else rows)
        object.__setattr__(self, part, expression)

    def _take_velocity(self, rows: int) -> None:
        velocity = as_column("robot velocity", self.velocity)
        if velocity.shape == (0, 0):
            velocity = self.system.lie_derivative(self.position)
            if ca.depends_on(velocity, self.system.u):
                velocity = ca.SX(0, 1)
        self._take("velocity", velocity, rows if velocity.numel() else 0)

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
        """Return u_fb = −k_p·position − k_d·velocity, for robots with one input for each coordinate.

        Raises:
            DesignError: A gain of the velocity, of a robot that has none.
        """
        if k_d and not self.velocity.numel():
            raise DesignError("k_d", k_d, "0 for a robot without a velocity")
        return -k_p * self.position - (k_d * self.velocity if k_d else 0)
