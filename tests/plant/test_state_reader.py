"""States of a robot that is not its model: readings that are old, missing, or of a robot with a clock of its own."""

from collections.abc import Sequence
from itertools import count
from math import exp, inf, isfinite, nan
from typing import cast

import numpy as np
import pytest
from passafe_protocol.messages import (
    Event,
    Header,
    Message,
    PlantInput,
    PlantPhase,
    PlantState,
    Received,
    Vector,
)
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.plant_driver import Reading
from passafe_services.plant.driven_robot import DrivenRobot
from passafe_services.plant.node import PlantNode
from passafe_services.plant.reading_check import OLDEST_NS
from passafe_services.plant.state_reader import StateReader
from passafe_services.plant.unpredicted_node import UnpredictedPlantNode
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import SampledPlant, damped_point, kinetic_energy
from passafe.limits import Limits

MS = 1_000_000
REST = (0.0,) * 4
ROBOT = damped_point(sigma=1.0, gamma_1=10.0)
PLANT = SampledPlant(ROBOT.system, kinetic_energy(ROBOT.velocity), 1e-3)


class ScriptedDriver:
    """A robot whose readings a test sets."""

    def __init__(self, *, has_own_clock: bool = True) -> None:
        self.has_own_clock = has_own_clock
        self.reading: Reading | None = None
        self.applied: list[tuple[Vector, int]] = []
        self.reads: list[int] = []

    def open(self) -> None: ...

    def close(self) -> None: ...

    def read(self, at_ns: int) -> Reading | None:
        self.reads.append(at_ns)
        return self.reading

    def apply(self, u: Vector, at_ns: int) -> None:
        self.applied.append((u, at_ns))


def reader_of(driver: ScriptedDriver) -> StateReader:
    return StateReader(driver, PLANT, x0=REST, u=(0.0, 0.0), period_ns=MS)


def test_a_fresh_reading_is_the_state() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    driver.reading = Reading((1.0, 0.0, 3.0, 4.0), 100 * MS)

    sample = reader.read(100 * MS)

    assert (sample.x, sample.y) == ((1.0, 0.0, 3.0, 4.0), (3.0, 4.0))
    assert (sample.stored_j, sample.energy_in_j) == (12.5, 0.0)


def test_energy_is_that_of_the_states_read() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    driver.reading = Reading((0.0, 0.0, 1.0, 0.0), 0)
    reader.read(0)
    reader.apply((2.0, 0.0), 0)
    driver.reading = Reading((0.0, 0.0, 3.0, 0.0), MS)

    assert reader.read(MS).energy_in_j == pytest.approx(2.0 * (1.0 + 3.0) / 2 * 1e-3, rel=1e-12)


def test_an_old_reading_is_led_through_what_was_applied() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    for at_ms, force in enumerate((5.0, 7.0, 9.0)):
        reader.apply((force, 0.0), at_ms * MS)
    driver.reading = Reading(REST, MS)

    speed = reader.read(3 * MS).x[2]

    held = 1.0 - exp(-1e-3)
    assert speed == pytest.approx(7.0 * held * exp(-1e-3) + 9.0 * held, rel=1e-12)
    assert not reader.is_blind


def test_too_old_a_reading_or_none_is_blindness() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    reader.read(0)
    assert reader.is_blind
    driver.reading = Reading(REST, 0)
    reader.read(OLDEST_NS)
    assert not reader.is_blind
    reader.read(OLDEST_NS + 1)
    assert reader.is_blind


def node_of(driver: ScriptedDriver, kind: type[PlantNode | UnpredictedPlantNode] = PlantNode) -> PlantNode:
    limits = Limits.of(2, 100.0, None)
    fail_safe = FailSafe(ROBOT, limits, period_ns=MS, hold_ns=3 * MS)
    robot = DrivenRobot(driver, PLANT, fail_safe, x0=REST, period_ns=MS, playout_ns=0)
    return cast(PlantNode, kind(robot, limits))  # both have the same methods


def sent(tick: int, at_ms: int, *, first: int | None = 0) -> Received:
    start = -1 if first is None else first
    body = PlantInput(tick, (float(tick), 0.0), (tick - 1) * MS, 3 * MS, start, -1, ())
    return Received(Header("filter", 1, 0, 0, 0, 0, 0), body, at_ms * MS)


def bodies(node: PlantNode, at_ms: int, *inbox: Received) -> Sequence[Message]:
    return [body if not callable(body) else body() for _, body in node.step(at_ms * MS, inbox)]


@pytest.mark.parametrize("kind", [PlantNode, UnpredictedPlantNode])
def test_a_blind_robot_brakes_and_tells_no_state(kind: type[PlantNode | UnpredictedPlantNode]) -> None:
    driver = ScriptedDriver()
    node, first = node_of(driver, kind), 0 if kind is PlantNode else None
    assert bodies(node, 99) == []
    driver.reading = Reading((0.0, 0.0, 2.0, 0.0), 100 * MS)
    [begun] = bodies(node, 100, sent(1, 100, first=first), sent(2, 100, first=first))
    assert isinstance(begun, PlantState)
    assert (begun.phase, begun.x) == (PlantPhase.RUNNING, (0.0, 0.0, 2.0, 0.0))
    driver.reading = None

    [event] = bodies(node, 101)

    assert isinstance(event, Event)
    assert event.text == "no state from the robot: fail-safe law in force at plant time 0.001 s"
    speed = 2.0 * exp(-1e-3) + 1.0 - exp(-1e-3)  # by the model, under the input in force: 1
    [(u, at_ns)] = driver.applied[-1:]
    assert (u, at_ns) == (pytest.approx((-9.0 * speed, 0.0), rel=1e-12), 101 * MS)  # K = γ₁ − σ = 9
    driver.reading = Reading(REST, 102 * MS)
    states = [body for body in bodies(node, 102) if isinstance(body, PlantState)]
    assert [(state.plant_ns, state.x) for state in states] == [(2 * MS, REST)]


def test_a_robot_that_went_on_is_read_once_after_a_stall() -> None:
    driver = ScriptedDriver()
    driver.reading = Reading(REST, 100 * MS)
    node = node_of(driver)
    bodies(node, 100, *(sent(tick, 100) for tick in range(1, 7)))
    driver.applied.clear()
    driver.reading = Reading(REST, 105 * MS)

    [state] = bodies(node, 105)

    assert isinstance(state, PlantState)
    assert (state.plant_ns, state.u) == (5 * MS, (6.0, 0.0))
    assert driver.applied == [((6.0, 0.0), 105 * MS)]


def test_a_simulation_is_stepped_through_a_stall() -> None:
    driver = ScriptedDriver(has_own_clock=False)
    driver.reading = Reading(REST, 2**62)
    node = node_of(driver)
    bodies(node, 100, *(sent(tick, 100) for tick in range(1, 7)))

    states = bodies(node, 105)

    assert [state.plant_ns for state in states if isinstance(state, PlantState)] == [k * MS for k in range(1, 6)]
    assert [at_ns for _, at_ns in driver.applied] == [k * MS for k in range(100, 106)]


def test_law_does_not_push_a_blind_robot_that_must_have_stopped() -> None:
    driver = ScriptedDriver()
    node = node_of(driver)
    driver.reading = Reading((0.0, 0.0, 2.0, 0.0), 100 * MS)
    bodies(node, 100, sent(1, 100))
    driver.reading = None
    for at_ms in range(101, 2101):
        bodies(node, at_ms)

    assert driver.applied[-1] == (pytest.approx((0.0, 0.0), abs=1e-6), 2100 * MS)


def test_energy_of_a_blind_stretch_is_that_of_the_model() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    driver.reading = Reading((0.0, 0.0, 2.0, 0.0), 100 * MS)
    reader.read(100 * MS)
    reader.apply((0.0, 0.0), 100 * MS)
    driver.reading = None

    assert [reader.read((100 + k) * MS).energy_in_j for k in range(1, 4)] == [0.0, 0.0, 0.0]
    assert reader.sample.x[2] == pytest.approx(2.0 * exp(-3e-3), rel=1e-12)


def test_stall_of_an_hour_takes_no_hour() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    driver.reading = Reading((0.0, 0.0, 2.0, 0.0), 0)
    reader.read(0)
    reader.apply((0.0, 0.0), 0)

    assert reader.read(3_600_000 * MS).x[2] == pytest.approx(2.0 * exp(-1.0), rel=1e-9)
    assert reader.is_blind


@pytest.mark.parametrize(
    "bad",
    [
        Reading((nan, 0.0, 0.0, 0.0), 101 * MS),
        Reading((0.0, 0.0, 0.0, inf), 101 * MS),
        Reading((1e200, 0.0, 1e200, 0.0), 101 * MS),
        Reading(REST, 101 * MS, true_x=(nan,) * 4),
        Reading(REST, 3_600_000 * MS),  # of another clock
    ],
)
def test_no_law_sees_what_is_no_state(bad: Reading) -> None:
    driver = ScriptedDriver()
    node = node_of(driver)
    driver.reading = Reading((0.0, 0.0, 2.0, 0.0), 100 * MS)
    bodies(node, 100, *(sent(tick, 100) for tick in range(1, 200)))
    driver.reading = bad

    events = [body for body in bodies(node, 101) if isinstance(body, Event)]
    for at_ms in range(102, 200):
        events += [body for body in bodies(node, at_ms) if isinstance(body, Event)]

    texts = [event.text.split(":")[0] for event in events]
    assert sorted(texts) == ["no state from the robot", "refused what was read of the robot"]
    assert all(isfinite(number) for u, _ in driver.applied for number in u)
    assert driver.applied[-1][0][0] < 0.0  # it brakes


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (Reading(REST[:3], 0), "driver reading x: got 3 numbers, allowed 4 numbers"),
        (Reading((), 0), "driver reading x: got 0 numbers, allowed 4 numbers"),
        (Reading(cast(Vector, ("a",) * 4), 0), "driver reading x: got .*, allowed 4 numbers"),
        (Reading(cast(Vector, "1234"), 0), "driver reading x: got '1234' .str., allowed 4 numbers"),
        (Reading(cast(Vector, {0.0, 1.0, 2.0, 3.0}), 0), "driver reading x: got .*set.*, allowed 4 numbers"),
        (Reading(cast(Vector, dict.fromkeys(range(4))), 0), "driver reading x: got .*dict.*, allowed 4 numbers"),
        (Reading(cast(Vector, count()), 0), "driver reading x: got count.*, allowed 4 numbers"),
        (Reading(cast(Vector, (1j,) * 4), 0), "driver reading x: got .*, allowed 4 numbers"),
        (Reading(cast(Vector, None), 0), "driver reading x: got None, allowed 4 numbers"),
        (Reading(REST, 0, true_x=(1.0,)), "driver reading true_x: got 1 numbers, allowed 4 numbers"),
        (Reading(REST, cast(int, nan)), "driver reading at_ns: got nan .float., allowed a whole number"),
        (Reading(REST, cast(int, "5")), "driver reading at_ns: got '5' .str., allowed a whole number"),
        (REST, "driver reading: got .*tuple.*, allowed a Reading or None"),
    ],
)
def test_reading_of_another_form_ends_the_process(bad: object, message: str) -> None:
    driver = ScriptedDriver()
    driver.reading = cast(Reading, bad)

    with pytest.raises(DriverError, match=message):
        reader_of(driver).read(0)


@pytest.mark.parametrize("x", [[1.0, 0.0, 3.0, 4.0], np.array([1.0, 0.0, 3.0, 4.0]), (1, 0, 3, 4)])
def test_numbers_may_be_of_any_sequence(x: object) -> None:
    driver = ScriptedDriver()
    driver.reading = Reading(cast(Vector, x), cast(int, np.int64(0)))

    assert reader_of(driver).read(0).x == (1.0, 0.0, 3.0, 4.0)


def test_reading_that_was_overtaken_is_not_the_present() -> None:
    driver = ScriptedDriver()
    reader = reader_of(driver)
    driver.reading = Reading((1.0, 0.0, 0.0, 0.0), 100 * MS)
    reader.read(100 * MS)
    driver.reading = Reading((0.5, 0.0, 0.0, 0.0), 90 * MS)

    assert reader.read(101 * MS).x == (1.0, 0.0, 0.0, 0.0)
