"""A robot as data: its functions as an instruction list with a digest, in effective scenarios and so in every log."""

import json
import zlib
from base64 import b64decode, b64encode
from collections.abc import Mapping
from dataclasses import replace
from hashlib import sha256
from math import inf
from typing import Annotated, Any, Final, Self

import casadi as ca
from pydantic import Field, ValidationInfo, model_validator

from passafe.errors import DesignError
from passafe.models.body_sphere import BodySphere
from passafe.models.drawing import Drawing
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.robot import Robot
from passafe.models.task_frame import TaskFrame
from passafe.parameter import Parameter
from passafe.system import System
from passafe_services.scenarios.fields import Config
from passafe_services.scenarios.robots.bound_symbols import BoundSymbols
from passafe_services.scenarios.robots.instruction_list import Expressions, expressions_of, listed

MOST_BYTES: Final = 4_000_000
"""Largest instruction list, unpacked."""

MOST_PACKED: Final = 700_000
"""Largest packed list, characters: the message that carries it must stay below 1 MiB."""

_UNSIGNED: Final = "unsigned"
"""Context of a validation before there is a digest."""

_OWN: Final = "barrier "
_HULL: Final = "hull "
_SPHERE: Final = "sphere "
_LATER: Final = ("fail_safe_top_speed", "fail_safe_gain")
"""Parts that were added when logs already had robots, with their digests."""

_SYSTEM: Final = ("f", "y", "port_y", "port_u")
_LAW: Final = ("position", "velocity", "fail_safe", "feedback", "storage")

Count = Annotated[int, Field(ge=1, le=64)]
Word = Annotated[str, Field(max_length=200)]


class CarriedDrawing(Config):
    """Parts of a robot's drawing that are no functions.

    Attributes:
        dimensions: 2 or 3.
        links: Pairs of points.
        outline: Corners, m.
        radii: Radii, m.
    """

    dimensions: Annotated[int, Field(ge=2, le=3)] = 2
    links: Annotated[tuple[tuple[int, int], ...], Field(max_length=64)] = ()
    outline: Annotated[tuple[tuple[float, float], ...], Field(max_length=64)] = ()
    radii: Annotated[tuple[float, ...], Field(max_length=64)] = ()


class CarriedSphere(Config):
    """Parts of a sphere of the body that are no functions.

    Attributes:
        name: Its name.
        radius_m: Radius, m.
    """

    name: Word
    radius_m: Annotated[float, Field(gt=0, le=1e3)]


class CarriedRobot(Config):
    """A robot that needs no code: written by passafe into effective scenarios, not by hand.

    Attributes:
        made_by: The function that returned it, or the entry point.
        built_with: Parameters that the function was called with.
        parameters: Parameters that its dynamics still contain as symbols, with their nominal values.
        states: n.
        inputs: m.
        commands: Coordinates of a command.
        points: Points in the plane that its position is made of.
        axes: Names of the coordinates of a command; empty if it is commanded by its input.
        input_unit: Unit of u.
        state_units: Unit of each state; empty if it is not known.
        drawing: How it is drawn; ``None``: at its points, or as coordinates.
        spheres: Spheres of its body.
        kept_gains: Gains that its fail-safe keeps, 1/s.
        fail_safe_dt_s: For how long an input of the fail-safe is held, s.
        fail_safe_top_speed: Largest speed at which it is proven to begin, m/s or rad/s; ``None``: any.
        fail_safe_gain: By which it multiplies −velocity; ``None``: not stated.
        fail_safe_condition: In words.
        functions: The instruction list, packed: zlib, then base64.
        digest: SHA-256 of everything else, hexadecimal.
    """

    made_by: Word
    built_with: dict[Word, float] = Field(default_factory=dict)
    parameters: dict[Word, float] = Field(default_factory=dict)
    states: Count
    inputs: Count
    commands: Count
    points: Annotated[int, Field(ge=0, le=32)]
    axes: Annotated[tuple[Word, ...], Field(max_length=64)] = ()
    input_unit: Word = ""
    state_units: Annotated[tuple[Word, ...], Field(max_length=64)] = ()
    drawing: CarriedDrawing | None = None
    spheres: Annotated[tuple[CarriedSphere, ...], Field(max_length=64)] = ()
    kept_gains: Annotated[tuple[float, ...], Field(max_length=16)] = (0.0,)
    fail_safe_dt_s: float = 0.0
    fail_safe_top_speed: float | None = None
    fail_safe_gain: float | None = None
    fail_safe_condition: Annotated[str, Field(max_length=1000)] = ""
    functions: Annotated[str, Field(max_length=MOST_PACKED)]
    digest: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]

    @model_validator(mode="after")
    def _is_whole(self, info: ValidationInfo) -> Self:
        if info.context != _UNSIGNED and _digest(self) != self.digest:
            raise ValueError(f"digest: got {self.digest[:8]}…, allowed that of the robot: it was changed or damaged")
        return self

    @property
    def position_unit(self) -> str:
        """Return the unit of a coordinate of the position: of joints, that of the first state where it is known."""
        if not self.points and self.state_units:
            return self.state_units[0]
        return "rad" if self.input_unit.startswith("rad") else "m"

    @classmethod
    def of(cls, robot: Robot, *, made_by: str, built_with: Mapping[str, float]) -> Self:
        """Return a robot as data.

        Args:
            robot: The robot.
            made_by: What made it, for people.
            built_with: Parameters that it was made with.

        Raises:
            DesignError: It is too large, or has an operation that no list holds.
            ValidationError: A number of states, points or names that a scenario cannot hold.
        """
        sizes = BoundSymbols.of(robot.system.n, robot.system.m)
        functions = listed(_symbols(robot.system, robot.task) | sizes.symbols, _expressions(robot, sizes))
        packed = b64encode(zlib.compress(functions.encode(), 9)).decode()
        if len(packed) > MOST_PACKED:
            raise DesignError("robot", f"functions of {len(packed)} bytes", f"at most {MOST_PACKED}")
        drawing, task = robot.drawing, robot.task
        parts: dict[str, Any] = {
            "made_by": made_by,
            "built_with": dict(built_with),
            "parameters": {parameter.name: parameter.value for parameter in robot.system.parameters},
            "states": robot.system.n,
            "inputs": robot.system.m,
            "commands": robot.commands,
            "points": robot.points,
            "axes": () if task is None else task.axes or tuple(f"axis {k + 1}" for k in range(task.size)),
            "input_unit": robot.input_unit,
            "state_units": robot.state_units,
            "drawing": None
            if drawing is None
            else CarriedDrawing(
                dimensions=drawing.dimensions, links=drawing.links, outline=drawing.outline, radii=drawing.radii
            ),
            "spheres": tuple(CarriedSphere(name=one.name, radius_m=one.radius_m) for one in robot.spheres),
            "kept_gains": robot.fail_safe_scope.kept_gains,
            "fail_safe_dt_s": robot.fail_safe_scope.dt_s,
            "fail_safe_top_speed": None if robot.fail_safe_scope.top_speed == inf else robot.fail_safe_scope.top_speed,
            "fail_safe_gain": robot.fail_safe_gain or None,
            "fail_safe_condition": robot.fail_safe_condition,
            "functions": packed,
        }
        unsigned = cls.model_validate(parts | {"digest": "0" * 64}, context=_UNSIGNED)
        return unsigned.model_copy(update={"digest": _digest(unsigned)})

    def robot(self) -> Robot:
        """Return the robot; nothing but elementary formulas is computed.

        Raises:
            DesignError: The functions are none of a robot.
        """
        x, u, t = ca.SX.sym("x", self.states), ca.SX.sym("u", self.inputs), ca.SX.sym("t")
        sizes = BoundSymbols.of(self.states, self.inputs)
        w, parameters = ca.SX.sym("w", self.commands), [Parameter.of(*each) for each in self.parameters.items()]
        theta = ca.vertcat(ca.SX(0, 1), *(parameter.symbol for parameter in parameters))
        made = expressions_of(self._unpacked(), {"x": x, "u": u, "t": t, "w": w, "theta": theta} | sizes.symbols)
        missing = {"f", "y", "position", "velocity", "fail_safe"} - made.keys()
        if missing:
            raise DesignError("robot", f"no {', '.join(sorted(missing))}", "all functions of a robot")
        return Robot(
            system=System(
                x=x, u=u, t=t, parameters=tuple(parameters), **{part: made[part] for part in _SYSTEM if part in made}
            ),
            position=made["position"],
            velocity=made["velocity"],
            fail_safe=made["fail_safe"],
            feedback=made.get("feedback"),
            storage=made.get("storage"),
            power_bounds=sizes.bounds(made["power bounds"]) if "power bounds" in made else None,
            spheres=self._spheres(made, sizes),
            points=self.points,
            fail_safe_scope=FailSafeScope(
                kept_gains=self.kept_gains,
                dt_s=self.fail_safe_dt_s,
                top_speed=inf if self.fail_safe_top_speed is None else self.fail_safe_top_speed,
            ),
            fail_safe_gain=self.fail_safe_gain or 0.0,
            fail_safe_condition=self.fail_safe_condition,
            stopping_hull=tuple(made[name] for name in made if name.startswith(_HULL)),
            barriers={name.removeprefix(_OWN): made[name] for name in made if name.startswith(_OWN)},
            task=TaskFrame(command=w, u_h=made["task"], axes=self.axes) if "task" in made else None,
            drawing=self._drawing(made),
            input_unit=self.input_unit,
            state_units=self.state_units,
        )

    def _spheres(self, made: Expressions, sizes: BoundSymbols) -> tuple[BodySphere, ...]:
        names = [f"{_SPHERE}{k}" for k in range(len(self.spheres))]
        if any(name not in made or f"{name} bounds" not in made for name in names):
            raise DesignError("robot", "no place of a sphere", "functions of every sphere")
        return tuple(
            BodySphere(
                name=one.name, centre=made[name], radius_m=one.radius_m, bounds=sizes.bounds(made[f"{name} bounds"])
            )
            for one, name in zip(self.spheres, names, strict=True)
        )

    def _drawing(self, made: Expressions) -> Drawing | None:
        if self.drawing is None:
            return None
        if not {"drawing points", "heading"} <= made.keys():
            raise DesignError("robot", "no drawing points", "functions of what it is drawn with")
        return Drawing(points=made["drawing points"], heading=made["heading"], **self.drawing.model_dump())

    def _unpacked(self) -> str:
        try:
            unpacking = zlib.decompressobj()
            data = unpacking.decompress(b64decode(self.functions, validate=True), MOST_BYTES)
            if unpacking.eof:
                return data.decode()
        except (ValueError, zlib.error):
            pass
        raise DesignError("robot", "functions that cannot be unpacked", f"a packed list of at most {MOST_BYTES} bytes")


def _symbols(system: System, task: TaskFrame | None) -> dict[str, ca.SX]:
    """Return the symbols of a robot's functions, in the order of the list."""
    command = ca.SX.sym("w", system.m) if task is None else task.command
    theta = ca.vertcat(ca.SX(0, 1), *(parameter.symbol for parameter in system.parameters))
    return {"x": system.x, "u": system.u, "t": system.t, "w": command, "theta": theta}


def _expressions(robot: Robot, sizes: BoundSymbols) -> Expressions:
    """Return every function of a robot by name."""
    made = {part: value for part, value in robot.system.general.items() if value.shape != (0, 0)}
    made |= {part: value for part in _LAW if (value := getattr(robot, part)) is not None}
    made |= {f"{_OWN}{name}": h for name, h in robot.barriers.items()}
    made |= {f"{_HULL}{k}": corner for k, corner in enumerate(robot.stopping_hull)}
    for k, sphere in enumerate(robot.spheres):
        made |= {f"{_SPHERE}{k}": sphere.centre, f"{_SPHERE}{k} bounds": sizes.orders(sphere.bounds)}
    if robot.power_bounds is not None:
        made["power bounds"] = sizes.orders(robot.power_bounds)
    if robot.task is not None:
        made["task"] = robot.task.u_h
    if robot.drawing is not None:
        made |= {"drawing points": robot.drawing.points, "heading": robot.drawing.heading}
    return made


def _digest(robot: CarriedRobot) -> str:
    """Return the digest of all parts of a robot but the digest itself, and but what earlier logs do not have."""
    parts = robot.model_dump(mode="json", exclude={"digest"})
    for later in _LATER:
        if parts[later] is None:
            del parts[later]
    return sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def built_robot(carried: CarriedRobot, **parameters: float) -> Robot:
    """Return a carried robot with a scenario's parameters.

    Raises:
        DesignError: A parameter has another value than the one that it was made with, and is none of the symbols that
            its dynamics still contain.
    """
    other = {name: value for name, value in parameters.items() if value != carried.built_with.get(name)}
    for name, value in other.items():
        if name not in carried.parameters:
            made = carried.built_with.get(name, "none")
            free = ", ".join(carried.parameters) or "nothing"
            allowed = f"{made}, with which {carried.made_by} made the robot: in its dynamics one may change {free}"
            raise DesignError(f"plant.parameters.{name}", value, allowed)
    robot = carried.robot()
    return replace(robot, system=robot.system.with_parameters(other)) if other else robot
