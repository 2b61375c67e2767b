"""Schema of ``[plant.driver]``: what reads and moves the robot."""

from typing import Annotated, Literal

from pydantic import Field

from passafe_services.scenarios.fields import Config

Name = Annotated[str, Field(min_length=1, max_length=60)]


class ModelDriverConfig(Config):
    """The exact model, or the scenario's truth."""

    kind: Literal["model"] = "model"


class HandConfig(Config):
    """A hand that pushes the simulated robot.

    Attributes:
        body: Body of the MJCF that it pushes.
        force_n: How hard, N; the direction is drawn anew each time.
        every_s: Time from one push to the next, s.
        for_s: How long each lasts, s.
        seed: Seed of the directions.
    """

    body: Name
    force_n: Annotated[float, Field(ge=0, le=1e4)]
    every_s: Annotated[float, Field(ge=0.01, le=1e4)] = 2.0
    for_s: Annotated[float, Field(ge=0, le=1e4)] = 0.3
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1


class MujocoDriverConfig(Config):
    """MuJoCo, with any model whose joints are the robot's coordinates; needs ``passafe[mujoco]``.

    Attributes:
        mjcf: A shipped model, ``seven-joint-arm``, or the path of an MJCF file.
        joints: Joints in the order of the robot's coordinates; all of them, in the file's order, if not given.
        control: ``acceleration`` by computed torque, or ``actuators``: u is the control signal of each.
        tracking_per_s: ω of the joints' own controller: how fast they follow their reference, 1/s.
        mass_scale: Factor on all masses and inertias but those that the controller knows.
        friction_n_m: Dry friction of every joint, N·m; that of the file if not given.
        hand: A hand that pushes the robot; none by default.
    """

    kind: Literal["mujoco"]
    mjcf: Annotated[str, Field(min_length=1, max_length=400)]
    joints: Annotated[tuple[Name, ...], Field(max_length=32)] = ()
    control: Literal["acceleration", "actuators"] = "acceleration"
    tracking_per_s: Annotated[float, Field(ge=0, le=1e3)] = 60.0
    mass_scale: Annotated[float, Field(gt=0, le=10)] = 1.0
    friction_n_m: Annotated[float, Field(ge=0, le=1e3)] | None = None
    hand: HandConfig | None = None


class UdpServoConfig(Config):
    """A servo that answers datagrams (``docs/how-to/own-driver.md``): the worked example of a driver for hardware.

    Attributes:
        host: Its address.
        port: Its port.
        timeout_s: Longest wait for its first answer, s.
    """

    kind: Literal["udp-servo"]
    host: Annotated[str, Field(min_length=1, max_length=253)] = "127.0.0.1"
    port: Annotated[int, Field(ge=1, le=65535)]
    timeout_s: Annotated[float, Field(gt=0, le=60)] = 2.0


class InstalledDriverConfig(Config):
    """A driver of an installed distribution, by entry point ``passafe.drivers``.

    Attributes:
        name: Name of the entry point.
        settings: What its function is called with besides the robot, by name.
    """

    kind: Literal["installed"]
    name: Name
    settings: dict[Name, bool | float | str] = Field(default_factory=dict)


AnyDriver = ModelDriverConfig | MujocoDriverConfig | UdpServoConfig | InstalledDriverConfig
DriverConfig = Annotated[AnyDriver, Field(discriminator="kind")]
