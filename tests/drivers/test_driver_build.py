"""Drivers by name: of a scenario, of the command line, of an installed distribution."""

import sys
from importlib.metadata import EntryPoint

import pytest
from passafe_services.cli.driver_text import driver_from
from passafe_services.cli.errors import OptionError
from passafe_services.drivers import build
from passafe_services.drivers.build import driver_of
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.model_driver import ModelDriver
from passafe_services.drivers.udp_servo import UdpServo
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.driver_schema import InstalledDriverConfig, MujocoDriverConfig, UdpServoConfig
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario

from passafe.errors import MissingPackageError

SCENARIO = load_scenario("notomista-cai-2020")


class Rail:
    has_own_clock = True

    def __init__(self, **settings: object) -> None:
        self.settings = settings


@pytest.fixture(scope="module")
def model() -> PlantModel:
    return PlantModel.of(SCENARIO)


def test_the_model_drives_unless_something_else_is_named(model: PlantModel) -> None:
    assert isinstance(driver_of(SCENARIO, model), ModelDriver)
    assert isinstance(driver_of(SCENARIO, model, UdpServoConfig(kind="udp-servo", port=8401)), UdpServo)


def test_an_installed_driver_gets_robot_and_settings(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("rail", f"{__name__}:Rail", build.ENTRY_POINTS)
    monkeypatch.setattr(EntryPoint, "load", lambda _: Rail)
    monkeypatch.setattr(build, "entry_points", lambda group: [entry] if group == build.ENTRY_POINTS else [])
    config = InstalledDriverConfig(kind="installed", name="rail", settings={"device": "/dev/rail1"})

    made = driver_of(SCENARIO, model, config)

    assert isinstance(made, Rail)
    assert made.settings == {
        "robot": model.robot,
        "x0": SCENARIO.plant.x0,
        "period_ns": 1_000_000,
        "device": "/dev/rail1",
    }
    with pytest.raises(DriverError, match="driver rial: got no such entry point, allowed rail"):
        driver_of(SCENARIO, model, config.model_copy(update={"name": "rial"}))


def test_hardware_is_refused_in_virtual_time() -> None:
    scenario = load_scenario("notomista-cai-2020", {"plant.driver": {"kind": "udp-servo", "port": 8401}})

    with pytest.raises(ScenarioError, match=r"plant.driver.kind: got udp-servo, allowed a simulation"):
        plant_node(scenario)


def test_the_command_line_names_a_driver_with_its_keys() -> None:
    made = driver_from("mujoco:mjcf=arms/mine.xml,mass_scale=1.1,control=actuators", SCENARIO)

    assert made == MujocoDriverConfig(kind="mujoco", mjcf="arms/mine.xml", mass_scale=1.1, control="actuators")
    assert driver_from("udp-servo:host=192.0.2.7,port=8400", SCENARIO) == UdpServoConfig(
        kind="udp-servo", host="192.0.2.7", port=8400
    )


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("udp-servo:8400", OptionError, "--driver: got '8400', allowed KIND"),
        ("udp-servo:port=none", ScenarioError, "plant.driver.port: got 'none', allowed a whole number"),
        ("udp-servo:port=8400,prot=1", ScenarioError, "plant.driver.prot"),
        ("udp-servos", ScenarioError, "plant.driver.kind: got 'udp-servos', allowed"),
    ],
)
def test_other_texts_are_refused(text: str, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        driver_from(text, SCENARIO)


def test_mujoco_is_named_where_it_is_not_installed(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "passafe_services.drivers.mujoco_driver", raising=False)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingPackageError, match=r"pip install 'passafe\[mujoco\]'"):
        driver_of(SCENARIO, model, MujocoDriverConfig(kind="mujoco", mjcf="seven-joint-arm"))
