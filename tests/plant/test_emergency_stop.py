"""No input has a way around the emergency stop, at either plant node, and none from before its clear has one after."""

from typing import TypeAlias

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from modelled_robot import modelled_robot
from passafe_protocol.messages import (
    UNSEQUENCED,
    EmergencyStop,
    Event,
    Header,
    Message,
    PlantInput,
    PlantPhase,
    PlantState,
    Received,
    StopClear,
)
from passafe_services.plant.build import plant_node
from passafe_services.plant.node import PlantNode
from passafe_services.plant.stop_latch import StopLatch
from passafe_services.plant.unpredicted_node import UnpredictedPlantNode
from passafe_services.plant_contract.fail_safe import FailSafe
from passafe_services.scenarios.load import load_scenario

from passafe import SampledPlant, damped_point
from passafe.limits import Limits

MS = 1_000_000
X0 = (1.0, -2.0, 0.5, 0.25)
LIMITS = Limits.of(2, 50.0)
ROBOT = damped_point(sigma=1.0, gamma_1=10.0)
PLANT = SampledPlant(ROBOT.system, ROBOT.system.x.T @ ROBOT.system.x, 1e-3)
FAIL_SAFE_RULE = FailSafe(ROBOT, LIMITS, period_ns=MS, hold_ns=6 * MS)

Node: TypeAlias = PlantNode | UnpredictedPlantNode


def make(kind: type[Node], *, playout_ms: int = 0, latch: StopLatch | None = None) -> Node:
    playout_ns = playout_ms * MS
    return kind(modelled_robot(PLANT, FAIL_SAFE_RULE, x0=X0, period_ns=MS, playout_ns=playout_ns, latch=latch), LIMITS)


def received(body: Message, at_ms: int, *, source: str = "filter", epoch: int = 1) -> Received:
    return Received(Header(source, epoch, 0, 0, 0, 0, 0), body, at_ms * MS)


def press(number: int, at_ms: int) -> Received:
    return received(EmergencyStop(number, "smoke"), at_ms, source="console")


def clear(number: int, at_ms: int) -> Received:
    return received(StopClear(number, "no smoke"), at_ms, source="console")


class Driver:
    """Drives a node: sends the inputs that a filter would send, one a period, each with a value of its own."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.sequenced = isinstance(node, PlantNode)
        self.state: PlantState | None = None
        self.at_ms = 0
        self.first_ms = self.break_ns = 0
        self.events: list[Event] = []

    def input(self, due_ms: int, value: float, *, stops_cleared: int = 0, tick: int | None = None) -> Received:
        start_ns = self.first_ms * MS if self.sequenced else UNSEQUENCED
        body = PlantInput(
            due_ms + 1 if tick is None else tick,
            (value, 0.0),
            due_ms * MS,
            6 * MS,
            start_ns,
            self.break_ns if self.sequenced else UNSEQUENCED,
            stops_cleared=stops_cleared,
        )
        return received(body, self.at_ms)

    def begin(self, first_ms: int, break_ns: int) -> None:
        self.first_ms, self.break_ns = first_ms, break_ns

    def step(self, *inbox: Received, steps: int = 1) -> list[PlantState]:
        found = []
        for k in range(steps):
            self.at_ms += 1
            for _, body in self.node.step(self.at_ms * MS, inbox if k == 0 else ()):
                if isinstance(body, PlantState):
                    found.append(body)
                elif isinstance(body, Event):
                    self.events.append(body)
        self.state = found[-1]
        return found


NODES = pytest.mark.parametrize("kind", [PlantNode, UnpredictedPlantNode])


def running(kind: type[Node], inputs: int = 30) -> Driver:
    """Return a plant that runs, with inputs waiting for the coming periods."""
    driver = Driver(make(kind))
    driver.begin(0, UNSEQUENCED)
    driver.step(*(driver.input(k, 1.0 + k) for k in range(inputs)))
    driver.step(steps=3)
    assert driver.state is not None
    assert driver.state.phase is PlantPhase.RUNNING
    return driver


@NODES
def test_the_fail_safe_law_is_in_force_with_the_next_period(kind: type[Node]) -> None:
    driver = running(kind)

    states = driver.step(press(9, driver.at_ms), steps=20)

    assert {state.phase for state in states} == {PlantPhase.FAIL_SAFE}
    assert all(state.u == FAIL_SAFE_RULE.law(state.x) for state in states)
    assert {(state.stop, state.stop_source, state.stops_cleared) for state in states} == {(9, "console", 0)}
    assert [event.text.partition(":")[0] for event in driver.events] == [
        "emergency stop latched, pressed at console",
        "emergency stop",
    ]


@NODES
def test_no_waiting_input_moves_it_after_the_clear(kind: type[Node]) -> None:
    driver = running(kind, inputs=60)
    driver.step(press(9, driver.at_ms), steps=5)

    states = driver.step(clear(9, driver.at_ms), steps=50)

    assert {state.phase for state in states} == {PlantPhase.FAIL_SAFE}
    assert {(state.stop, state.stops_cleared) for state in states} == {(0, 1)}


@NODES
@pytest.mark.parametrize("arrives", ["before the clear", "with the clear", "after the clear"])
def test_an_input_of_before_the_clear_is_refused(kind: type[Node], arrives: str) -> None:
    driver = running(kind, inputs=6)
    stopped = driver.step(press(9, driver.at_ms), steps=4)[-1]
    driver.begin(20, stopped.sequence_break_ns)
    late = [driver.input(20 + k, 30.0 + k, tick=100 + k) for k in range(20)]  # a filter that knows of no stop

    inboxes = {
        "before the clear": [late, [clear(9, 0)], []],
        "with the clear": [[], [clear(9, 0), *late], []],
        "after the clear": [[], [clear(9, 0)], late],
    }[arrives]
    states = [state for inbox in inboxes for state in driver.step(*inbox)] + driver.step(steps=40)

    assert {state.phase for state in states} == {PlantPhase.FAIL_SAFE}
    assert states[-1].inputs_refused == 20


@NODES
def test_an_input_that_knows_of_the_clear_drives_again(kind: type[Node]) -> None:
    driver = running(kind, inputs=6)
    driver.step(press(9, driver.at_ms), steps=4)
    cleared = driver.step(clear(9, driver.at_ms))[-1]
    first_ms = cleared.plant_ns // MS + 3
    driver.begin(first_ms, cleared.sequence_break_ns)

    states = driver.step(*(driver.input(first_ms + k, 7.0, stops_cleared=1) for k in range(9)), steps=8)

    assert [state.phase for state in states] == [PlantPhase.FAIL_SAFE] * 2 + [PlantPhase.RUNNING] * 6
    assert states[-1].u == (7.0, 0.0)


@NODES
def test_a_plant_that_waits_stays_where_it_is(kind: type[Node]) -> None:
    driver = Driver(make(kind, playout_ms=5))
    driver.begin(0, UNSEQUENCED)
    driver.step(driver.input(0, 1.0))

    states = driver.step(press(4, 1), driver.input(1, 1.0), steps=20)
    states += driver.step(clear(4, 21), driver.input(2, 1.0), steps=20)

    assert {(state.phase, state.x, state.plant_ns) for state in states} == {(PlantPhase.WAITING, X0, 0)}
    driver.begin(0, UNSEQUENCED)
    driver.step(driver.input(0, 2.0, stops_cleared=1), steps=7)
    assert driver.state is not None
    assert driver.state.phase is not PlantPhase.WAITING


@NODES
def test_a_plant_may_start_stopped(kind: type[Node]) -> None:
    driver = Driver(make(kind, latch=StopLatch(5)))
    driver.begin(0, UNSEQUENCED)

    states = driver.step(driver.input(0, 1.0), steps=9)

    assert {(state.phase, state.stop, state.stop_source) for state in states} == {(PlantPhase.WAITING, 5, "plant")}


@pytest.mark.parametrize("prediction", [True, False])
def test_a_scenarios_plant_may_start_stopped(prediction: bool) -> None:
    node = plant_node(load_scenario("notomista-cai-2020", {"filter.prediction": prediction}), started_with=77)

    [(_, state)] = node.step(MS, [])

    assert isinstance(state, PlantState)
    assert (state.stop, state.stop_source) == (77, "plant")


@NODES
def test_skipped_periods_are_under_the_stop_too(kind: type[Node]) -> None:
    driver = running(kind, inputs=60)
    at_ms = driver.at_ms + 25  # the process was suspended meanwhile

    bodies = [body for _, body in driver.node.step(at_ms * MS, [press(9, at_ms)]) if isinstance(body, PlantState)]

    assert len(bodies) == 25
    assert {state.phase for state in bodies} == {PlantPhase.FAIL_SAFE}


Action: TypeAlias = tuple[str, int, int]
ACTIONS = st.lists(
    st.tuples(
        st.sampled_from(["press", "clear", "input", "input", "input", "step"]), st.integers(0, 3), st.integers(-2, 12)
    ),
    max_size=120,
)


@NODES
@settings(max_examples=60)
@given(actions=ACTIONS)
def test_whatever_comes_only_inputs_of_after_the_clear_act(kind: type[Node], actions: list[Action]) -> None:
    """Every input has a value of its own, so that the one in force tells when it was received and what it knew."""
    driver = Driver(make(kind))
    latched, cleared, last_clear = 0, 0, 0
    sent: dict[float, tuple[int, int]] = {}
    inbox: list[Received] = []
    for number, (action, which, ahead) in enumerate(actions, start=1):
        state = driver.state
        if action == "press":
            inbox.append(press(number, driver.at_ms))
            latched = number
        elif action == "clear" and latched and which:
            inbox.append(clear(latched, driver.at_ms))
            latched, cleared, last_clear = 0, cleared + 1, number
        elif action == "input":
            knows, value = max(cleared - which, 0), number * 0.01
            due_ms = (0 if state is None else state.plant_ns // MS) + ahead
            driver.begin(max(due_ms, 0), UNSEQUENCED if state is None else state.sequence_break_ns)
            sent[value] = (number, knows)
            inbox.append(driver.input(max(due_ms, 0), value, stops_cleared=knows, tick=number))
        else:
            states = driver.step(*inbox, steps=1 + which)
            inbox = []
            for each in states:
                assert each.stop == latched
                if latched:
                    assert each.phase in {PlantPhase.FAIL_SAFE, PlantPhase.WAITING}
                if each.phase is PlantPhase.RUNNING:
                    at, knew = sent[each.u[0]]
                    assert at > last_clear
                    assert knew == cleared
