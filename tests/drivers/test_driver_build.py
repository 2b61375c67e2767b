"""Drivers by name: of a scenario, of the command line, of an installed distribution."""

import signal
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import EntryPoint

import pytest
from passafe_protocol.messages import Vector
from passafe_services.cli.driver_text import driver_from
from passafe_services.cli.errors import OptionError
from passafe_services.drivers import build
from passafe_services.drivers.build import driver_of
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.model_driver import ModelDriver
from passafe_services.drivers.plant_driver import Reading
from passafe_services.drivers.strange_driver import StrangeDriver
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
    closed = False

    def __init__(self, *, fault: str = "", error: BaseException | None = None, **settings: object) -> None:
        self.settings = settings
        self.fault, self.error = fault, error
        Rail.closed = False
        self.at("made")

    def at(self, place: str) -> None:
        if place == self.fault:
            raise OSError(f"no bus\nin {place}") if self.error is None else self.error

    def open(self) -> None:
        self.at("open")

    def read(self, at_ns: int) -> None:
        self.at("read")

    def apply(self, u: Vector, at_ns: int) -> None:
        self.at("apply")

    def close(self) -> None:
        self.at("close")
        Rail.closed = True


def installed(monkeypatch: pytest.MonkeyPatch, load: Callable[[], object], *values: str) -> InstalledDriverConfig:
    entries = [EntryPoint("rail", value, build.ENTRY_POINTS) for value in values or ("mine:rail",)]
    monkeypatch.setattr(EntryPoint, "load", lambda _: load())
    monkeypatch.setattr(build, "entry_points", lambda group: entries if group == build.ENTRY_POINTS else [])
    return InstalledDriverConfig(kind="installed", name="rail")


@pytest.fixture(scope="module")
def model() -> PlantModel:
    return PlantModel.of(SCENARIO)


def test_the_model_drives_unless_something_else_is_named(model: PlantModel) -> None:
    assert isinstance(driver_of(SCENARIO, model), ModelDriver)
    assert isinstance(driver_of(SCENARIO, model, UdpServoConfig(kind="udp-servo", port=8401)), UdpServo)


def test_an_installed_driver_gets_robot_and_settings(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    config = installed(monkeypatch, lambda: Rail).model_copy(update={"settings": {"device": "/dev/rail1"}})

    made = driver_of(SCENARIO, model, config)

    assert isinstance(made, StrangeDriver)
    assert isinstance(made.driver, Rail)
    assert made.has_own_clock
    assert made.driver.settings == {
        "robot": model.robot,
        "x0": SCENARIO.plant.x0,
        "period_ns": 1_000_000,
        "device": "/dev/rail1",
    }
    with pytest.raises(DriverError, match="driver rial: got no such entry point, allowed rail"):
        driver_of(SCENARIO, model, config.model_copy(update={"name": "rial"}))


@pytest.mark.parametrize("place", ["made", "open", "read", "apply", "close"])
def test_what_an_installed_driver_raises_is_one_line(
    place: str, model: PlantModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = installed(monkeypatch, lambda: Rail).model_copy(update={"settings": {"fault": place}})

    def driven() -> None:
        made = driver_of(SCENARIO, model, config)
        made.open()
        made.read(0)
        made.apply((), 0)
        made.close()

    with pytest.raises(DriverError) as raised:
        driven()

    words = f"driver rail: {place}: got OSError: no bus in {place}, allowed no exception but DriverError"
    assert str(raised.value) == words
    assert Rail.closed == (place in {"open", "read", "apply"})  # closed at once


@pytest.mark.parametrize("place", ["made", "open", "read", "apply", "close"])
@pytest.mark.parametrize("error", [KeyboardInterrupt(), SystemExit(0), GeneratorExit(), MemoryError()])
def test_driver_cannot_end_the_process_by_itself(
    place: str, error: BaseException, model: PlantModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = installed(monkeypatch, lambda: Rail)

    def driven() -> None:
        made = driver_of(SCENARIO, model, config.model_copy(update={"settings": {"fault": place, "error": error}}))
        made.open()
        made.read(0)
        made.apply((), 0)
        made.close()

    with pytest.raises(DriverError, match=f"driver rail: {place}: got {type(error).__name__}.*, allowed no exception"):
        driven()


def test_ctrl_c_is_no_fault_of_the_driver(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    class Slow(Rail):
        def open(self) -> None:
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            driver_of(SCENARIO, model, installed(monkeypatch, lambda: Slow)).open()
    finally:
        signal.signal(signal.SIGINT, before)

    assert Rail.closed


def test_call_under_way_has_a_number_and_a_name(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    class Curious(Rail):
        def at(self, place: str) -> None:
            calls.append(made.call if place != "made" else None)

    made = driver_of(SCENARIO, model, installed(monkeypatch, lambda: Curious))
    assert isinstance(made, StrangeDriver)
    made.open()
    made.read(0)
    made.apply((), 0)
    made.close()
    made.close()

    assert calls == [None, None, (1, "driver rail: read"), (2, "driver rail: apply"), (3, "driver rail: close")]
    assert made.call is None


def test_only_the_model_accounts_for_its_energies(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    sample = model.dynamics.at(SCENARIO.plant.x0)

    class Boastful(Rail):
        def read(self, at_ns: int) -> Reading:
            return Reading((1.0, 2.0), at_ns, sample, (3.0, 4.0))

    made = driver_of(SCENARIO, model, installed(monkeypatch, lambda: Boastful))

    assert made.read(5) == Reading((1.0, 2.0), 5, None, (3.0, 4.0))


@pytest.mark.parametrize(
    ("load", "message"),
    [
        (lambda: lambda **_: None, r"driver rail: got None without open, read, apply, close, has_own_clock"),
        (lambda: lambda **_: Rail, r"driver rail: open: got TypeError"),
        (lambda: 5, r"driver rail: made: got TypeError: 'int' object is not callable"),
        (lambda: int, r"driver rail: made: got TypeError"),
        (lambda: import_module("no_such_module_of_rails"), r"driver rail: made: got ModuleNotFoundError"),
    ],
)
def test_what_is_no_driver_is_refused(
    load: Callable[[], object], message: str, model: PlantModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = installed(monkeypatch, load)
    with pytest.raises(DriverError, match=message):
        driver_of(SCENARIO, model, config).open()


def test_two_drivers_of_one_name_are_refused(model: PlantModel, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DriverError, match="driver rail: got 2 entry points: mine:rail and theirs:rail, allowed one"):
        driver_of(SCENARIO, model, installed(monkeypatch, lambda: Rail, "theirs:rail", "mine:rail"))


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
