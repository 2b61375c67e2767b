"""MuJoCo as the robot: contacts, friction, masses and a time step that are not those of the model."""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Final

import mujoco
import numpy as np
from passafe_protocol.messages import Vector

from passafe.numerics.workspace import Array
from passafe.sampled_plant import SampledPlant
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.hand import Hand
from passafe_services.drivers.plant_driver import Reading
from passafe_services.scenarios.driver_schema import MujocoDriverConfig

NAME: Final = "mujoco"
FAR_M: Final = 1.0
"""Distance beyond which geoms are not looked at, m."""

LARGEST_LAG: Final = 0.03
"""Distance of a joint from its reference, rad or m, beyond which the reference is drawn after it: a robot that is held
yields, and does not jump when it is let go."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Worlds:
    """The same robot twice.

    Attributes:
        true: As it is simulated.
        nominal: As the controller of the joints knows it.
    """

    true: "mujoco.MjModel"
    nominal: "mujoco.MjModel"


class MujocoDriver:
    """Steps a MuJoCo model under the input applied last, until a state is asked for.

    With ``control = "acceleration"`` the joints have a controller of their own, as those of an arm have: a reference
    that moves as the filter's model does under u, and computed torque τ = M(q)a + C(q, q̇)q̇ + g(q) of the nominal
    model, a = q̈ᵣ + 2ω(q̇ᵣ − q̇) + ω²(qᵣ − q). The state that it reports is the reference, as such controllers do; the
    joints lie within the tracking error of it, which is reported beside it (``Reading.true_x``), and which the spheres
    of a body have to cover. With ``control = "actuators"`` u goes to the model's actuators, and the state is that of
    the joints.

    Attributes:
        has_own_clock: False: a simulation.
        least_distance_m: Least distance so far between geoms of the robot and of its surroundings, m, by MuJoCo's own
            collision check at every step; negative where they penetrate. ``FAR_M`` before any came near.
    """

    has_own_clock = False

    def __init__(self, config: MujocoDriverConfig, plant: SampledPlant, *, x0: Sequence[float], period_ns: int) -> None:
        """Load the model and put it at rest at x0.

        Args:
            config: Part of a scenario.
            plant: The robot as the filter models it, which the reference follows; stepped with the period.
            x0: Initial state: positions of the joints, then their rates.
            period_ns: Period of the plant, ns.

        Raises:
            DriverError: A file that is no MJCF, or one that does not fit the robot.
        """
        self._config, self._period_ns = config, period_ns
        self._worlds = _Worlds(true=_loaded(config), nominal=_loaded(config))
        self._joints = _Joints.of(self._worlds.true, config, len(x0) // 2)
        self._steps = _set_step(self._worlds.true, period_ns)
        _alter(self._worlds.true, config, self._joints)
        self._near = _Surroundings.of(self._worlds.true)
        self._hand = None if config.hand is None else Hand.of(self._worlds.true, config.hand)
        self._plant = plant
        self._x0 = np.array(x0, dtype=float)
        self.open()

    def open(self) -> None:
        """Put the robot at rest at x0, at time 0."""
        self._data = mujoco.MjData(self._worlds.true)
        self._twin = mujoco.MjData(self._worlds.nominal)
        half = len(self._x0) // 2
        self._data.qpos[self._joints.places], self._data.qvel[self._joints.rates] = self._x0[:half], self._x0[half:]
        mujoco.mj_forward(self._worlds.true, self._data)
        self._reference: Vector = tuple(self._x0.tolist())
        self._u: Vector = ()
        self._at_ns = 0
        self.least_distance_m = FAR_M

    def read(self, at_ns: int) -> Reading:
        """Return the state at ``at_ns``; x0 before the first input."""
        while self._u and self._at_ns + self._period_ns <= at_ns:
            self._advance()
            self._at_ns += self._period_ns
        if self._config.control == "actuators":
            return Reading(self._joint_state(), at_ns)
        return Reading(self._reference, at_ns, true_x=self._joint_state())

    def apply(self, u: Vector, at_ns: int) -> None:
        """Put an input in force."""
        self._u, self._at_ns = u, at_ns

    def close(self) -> None:
        """Do nothing: a simulation stops when it is asked no more."""

    def _joint_state(self) -> Vector:
        data, joints = self._data, self._joints
        return (*data.qpos[joints.places].tolist(), *data.qvel[joints.rates].tolist())

    def _advance(self) -> None:
        """Advance by one period, in the model's own steps."""
        if self._config.control == "actuators":
            for _ in range(self._steps):
                self._data.ctrl[:] = self._u
                self._step()
            return
        half, begun = len(self._x0) // 2, np.array(self._reference)
        ended = np.array(self._plant.advance(self._reference, self._u).x)
        acceleration = (ended - begun)[half:] / self._plant.dt_s
        for k in range(self._steps):
            passed = k / self._steps
            self._data.qfrc_applied[self._joints.rates] = self._torque(begun + passed * (ended - begun), acceleration)
            self._step()
        q = self._data.qpos[self._joints.places]
        ended[:half] = q + np.clip(ended[:half] - q, -LARGEST_LAG, LARGEST_LAG)
        self._reference = tuple(ended.tolist())

    def _step(self) -> None:
        model, data = self._worlds.true, self._data
        if self._hand is not None:
            self._hand.push(data)
        mujoco.mj_step(model, data)
        self.least_distance_m = min(self.least_distance_m, self._near.distance(model, data))

    def _torque(self, reference: Array, acceleration: Array) -> Array:
        """Return the controller's torque, N·m, within the limits of the joints."""
        data, twin, joints, half = self._data, self._twin, self._joints, len(reference) // 2
        q, v, rate = data.qpos[joints.places], data.qvel[joints.rates], self._config.tracking_per_s
        asked = acceleration + 2 * rate * (reference[half:] - v) + rate**2 * (reference[:half] - q)
        twin.qpos[joints.places], twin.qvel[joints.rates] = q, v
        mujoco.mj_fwdPosition(self._worlds.nominal, twin)
        mujoco.mj_fwdVelocity(self._worlds.nominal, twin)
        wanted, torque = np.zeros(self._worlds.nominal.nv), np.zeros(self._worlds.nominal.nv)
        wanted[joints.rates] = asked
        mujoco.mj_mulM(self._worlds.nominal, twin, torque, wanted)
        found: Array = np.clip((torque + twin.qfrc_bias)[joints.rates], joints.low, joints.high)
        return found


@dataclass(frozen=True, kw_only=True, slots=True)
class _Joints:
    """Places of the robot's joints in MuJoCo's vectors.

    Attributes:
        places: In qpos.
        rates: In qvel.
        low: Least torque of each, N·m.
        high: Largest.
    """

    places: list[int]
    rates: list[int]
    low: Array
    high: Array

    @classmethod
    def of(cls, model: "mujoco.MjModel", config: MujocoDriverConfig, count: int) -> "_Joints":
        names = config.joints or tuple(model.joint(i).name for i in range(model.njnt))
        known = {model.joint(i).name: i for i in range(model.njnt)}
        unknown = [name for name in names if name not in known]
        if unknown or len(names) != count:
            got = f"the joints {unknown}" if unknown else f"{len(names)} joints for {count} coordinates"
            raise DriverError(NAME, got, f"one of {sorted(known)} for each coordinate")
        found = [known[name] for name in names]
        simple = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
        if any(model.jnt_type[i] not in simple for i in found):
            raise DriverError(NAME, "a joint with several coordinates", "hinges and slides")
        limits = np.array(
            [model.jnt_actfrcrange[i] if model.jnt_actfrclimited[i] else (-np.inf, np.inf) for i in found]
        )
        return cls(
            places=[int(model.jnt_qposadr[i]) for i in found],
            rates=[int(model.jnt_dofadr[i]) for i in found],
            low=limits[:, 0],
            high=limits[:, 1],
        )


@dataclass(frozen=True, kw_only=True, slots=True)
class _Surroundings:
    """Pairs of geoms of the robot and of what does not move with it, whose collisions the model lets happen.

    Attributes:
        pairs: Numbers of both geoms.
    """

    pairs: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, model: "mujoco.MjModel") -> "_Surroundings":
        moving = [g for g in range(model.ngeom) if model.body_weldid[model.geom_bodyid[g]] != 0]
        fixed = [g for g in range(model.ngeom) if g not in moving]
        types, affinities = model.geom_contype, model.geom_conaffinity
        return cls(
            pairs=tuple((a, b) for a in moving for b in fixed if types[a] & affinities[b] or types[b] & affinities[a])
        )

    def distance(self, model: "mujoco.MjModel", data: "mujoco.MjData") -> float:
        """Return the least distance of all pairs, m."""
        return min((mujoco.mj_geomDistance(model, data, a, b, FAR_M, None) for a, b in self.pairs), default=FAR_M)


def _loaded(config: MujocoDriverConfig) -> "mujoco.MjModel":
    shipped = files("passafe_services.drivers") / "mjcf" / f"{config.mjcf}.xml"
    path = Path(str(shipped)) if shipped.is_file() else Path(config.mjcf)
    if not path.is_file():
        raise DriverError(NAME, f"no file {config.mjcf}", "a shipped model, or the path of an MJCF file")
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise DriverError(NAME, f"{path}: {' '.join(str(error).split())}", "an MJCF file") from error


def _set_step(model: "mujoco.MjModel", period_ns: int) -> int:
    """Return how many steps make a period; a step that does not divide it is shortened."""
    period_s = period_ns * 1e-9
    steps = max(1, int(np.ceil(period_s / float(model.opt.timestep) - 1e-9)))
    model.opt.timestep = period_s / steps
    return steps


def _alter(model: "mujoco.MjModel", config: MujocoDriverConfig, joints: _Joints) -> None:
    """Make the simulated robot another than the controller's: masses and the friction of the joints."""
    model.body_mass *= config.mass_scale
    model.body_inertia *= config.mass_scale
    if config.friction_n_m is not None:
        model.dof_frictionloss[joints.rates] = config.friction_n_m
    mujoco.mj_setConst(model, mujoco.MjData(model))
