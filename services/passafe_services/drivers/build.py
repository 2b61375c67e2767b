"""Builds the driver that a scenario, or the command line, names."""

from importlib.metadata import entry_points
from typing import Final

from passafe.errors import MissingPackageError
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.model_driver import ModelDriver
from passafe_services.drivers.plant_driver import PlantDriver
from passafe_services.drivers.strange_driver import made
from passafe_services.drivers.true_model_driver import TrueModelDriver
from passafe_services.drivers.udp_servo import UdpServo
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.driver_schema import (
    AnyDriver,
    InstalledDriverConfig,
    ModelDriverConfig,
    MujocoDriverConfig,
)
from passafe_services.scenarios.schema import Scenario

LARGEST_READING: Final = 1e3
"""Magnitude beyond which no position or rate is believed, m or rad, and per second."""

ENTRY_POINTS: Final = "passafe.drivers"
"""Group of entry points by which installed distributions add drivers."""


def driver_of(scenario: Scenario, model: PlantModel, config: AnyDriver | None = None) -> PlantDriver:
    """Return a driver; one with a clock of its own is to be opened before it is used.

    Args:
        scenario: The scenario.
        model: Its compiled model.
        config: Driver in the place of the scenario's.

    Raises:
        DriverError: It does not fit the robot, is not installed, or is no driver.
        MissingPackageError: It needs a package that is not installed.
    """
    config = scenario.plant.driver if config is None else config
    x0, period_ns = scenario.plant.x0, model.period_ns
    truth = scenario.plant.truth
    if isinstance(config, ModelDriverConfig) and truth is not None:
        return TrueModelDriver.of(scenario, model, truth)
    if isinstance(config, ModelDriverConfig):
        return ModelDriver(model.dynamics, x0=x0, period_ns=period_ns)
    if isinstance(config, MujocoDriverConfig):
        try:
            from passafe_services.drivers.mujoco_driver import MujocoDriver  # noqa: PLC0415 - an extra
        except ModuleNotFoundError as error:
            raise MissingPackageError.of(error, "mujoco") from error
        return MujocoDriver(config, model.dynamics, x0=x0, period_ns=period_ns)
    if isinstance(config, InstalledDriverConfig):
        return _installed(config, model, x0)
    return UdpServo(config, model.robot.system.m, (LARGEST_READING,) * len(x0))


def _installed(config: InstalledDriverConfig, model: PlantModel, x0: tuple[float, ...]) -> PlantDriver:
    entries = [entry for entry in entry_points(group=ENTRY_POINTS) if entry.name == config.name]
    if not entries:
        found = ", ".join(sorted({entry.name for entry in entry_points(group=ENTRY_POINTS)}))
        raise DriverError(config.name, "no such entry point", found or "none: no distribution brings one")
    values = sorted({entry.value for entry in entries})
    if len(values) > 1:
        raise DriverError(config.name, f"{len(values)} entry points: {' and '.join(values)}", "one of that name")
    settings = config.settings
    return made(config.name, lambda: entries[0].load()(robot=model.robot, x0=x0, period_ns=model.period_ns, **settings))
