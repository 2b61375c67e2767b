"""The operator node: scripts aligned with plant time, what a source is shown, keys."""

from math import exp

import pytest
from msgspec.structs import replace
from passafe_protocol.messages import (
    Header,
    OperatorCommand,
    PlantPhase,
    Received,
)
from passafe_protocol.topics import COMMAND
from passafe_services.operator.keyboard.keyboard import RAMP_S, Keyboard
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.node import OperatorNode
from passafe_services.operator.sources.lag import Lag
from passafe_services.operator.sources.source import SourceClock
from stepped_operator import EPOCH, MS, Onlooker, TimeTeller, asked_for, lease, state, tick


def test_step_sends_the_command_of_the_source() -> None:
    node = OperatorNode(Lag(target=(-3.0, 0.0), time_constant_s=0.2), epoch=EPOCH)
    (outgoing,) = node.step(700 * MS, [state(200 * MS, 700 * MS)])
    assert outgoing[0] is COMMAND
    assert isinstance(outgoing[1], OperatorCommand)
    assert outgoing[1].u_h == pytest.approx((-3.0 * (1 - exp(-1)), 0.0))
    assert outgoing[1].u_h_rate == pytest.approx((-15.0 * exp(-1), 0.0))
    assert outgoing[1].enabled
    assert outgoing[1].device == "lag"


def test_a_script_stands_at_its_beginning_until_the_plant_moves() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert asked_for(node, 10 * MS) == 0.0
    assert asked_for(node, 20 * MS, state(0, 15 * MS, PlantPhase.WAITING)) == 0.0
    assert asked_for(node, 900 * MS) == 0.0
    assert asked_for(node, 901 * MS, state(-5 * MS, 901 * MS, PlantPhase.WAITING)) == 0.0


def test_a_script_already_enables_the_robot_while_it_waits() -> None:
    (outgoing,) = OperatorNode(Lag(target=(1.0,), time_constant_s=1.0), epoch=EPOCH).step(0, ())
    assert outgoing[1] == OperatorCommand((0.0,), (1.0,), True, "lag")


@pytest.mark.parametrize("phase", [PlantPhase.RUNNING, PlantPhase.HOLDING, PlantPhase.FAIL_SAFE])
def test_script_time_is_plant_time_plus_the_newest_states_age(phase: PlantPhase) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert asked_for(node, 5_000 * MS, state(120 * MS, 4_998 * MS, phase)) == 0.122
    assert asked_for(node, 5_010 * MS) == 0.132
    assert asked_for(node, 5_011 * MS, state(125 * MS, 5_011 * MS), state(130 * MS, 5_011 * MS)) == 0.13


def test_plant_time_is_exact_to_1_ns_after_long_uptimes() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    uptime_ns = 400 * 86_400 * 10**9
    for index in range(1000):
        plant_ns = 3_600 * 10**9 + index * MS
        assert asked_for(node, uptime_ns + index * MS, state(plant_ns, uptime_ns + index * MS)) == plant_ns / 1e9


def test_reordered_state_does_not_set_the_script_back() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    older, newer = state(100 * MS, 111 * MS), state(110 * MS, 110 * MS)  # numbered in this order
    assert asked_for(node, 111 * MS, newer, older) == 0.111


def test_command_echoes_the_newest_state_and_its_time_here() -> None:
    """The plant's clock is 70 s ahead; a state that was overtaken is not echoed."""
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    body, ahead_ns = state(0, 0).body, 70_000 * MS
    newer, older = (
        Received(Header("plant", 4, number, sent_ms * MS + ahead_ns, 0, 0, 0), body, arrived_ms * MS)
        for number, sent_ms, arrived_ms in ((6, 10, 11), (5, 8, 12))
    )
    echoes = []
    for now_ms, inbox in ((0, []), (20, [newer, older]), (35, [])):
        [(_, sent)] = node.step(now_ms * MS, inbox)
        assert isinstance(sent, OperatorCommand)
        echoes.append((sent.echoed_epoch, sent.echoed_ns, sent.echoed_for_ns))

    assert echoes == [(0, 0, 0), (4, 70_010 * MS, 9 * MS), (4, 70_010 * MS, 24 * MS)]


def test_a_plant_that_starts_again_starts_the_script_again() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert asked_for(node, 100 * MS, state(50 * MS, 100 * MS)) == 0.05
    assert asked_for(node, 200 * MS, state(0, 200 * MS, PlantPhase.WAITING)) == 0.0
    assert asked_for(node, 300 * MS, state(1 * MS, 300 * MS)) == 0.001


def test_same_inbox_gives_same_commands_at_any_start_time() -> None:
    def run(start_ns: int) -> list[object]:
        node = OperatorNode(Lag(target=(-3.0, 1.0), time_constant_s=0.2), epoch=EPOCH)
        inboxes = [[] if k < 5 else [state((k - 5) * MS, start_ns + k * MS)] for k in range(200)]
        commands = [node.step(start_ns + k * MS, inbox)[0][1] for k, inbox in enumerate(inboxes)]
        assert [command.echoed_ns for command in commands[5:]] == [start_ns + k * MS for k in range(5, 200)]
        return [replace(command, echoed_ns=0) for command in commands]

    assert run(0) == run(123_456_789_012_345)


def test_a_person_runs_on_local_time_from_the_first_step() -> None:
    node = OperatorNode(TimeTeller(clock=SourceClock.LOCAL), epoch=EPOCH)
    assert asked_for(node, 7_000 * MS) == 0.0
    assert asked_for(node, 7_250 * MS, state(3 * MS, 7_250 * MS)) == 0.25


def test_observing_source_gets_the_newest_state_first() -> None:
    source = Onlooker()
    node = OperatorNode(source, epoch=EPOCH)
    node.step(0, ())
    node.step(1 * MS, [state(1 * MS, 1 * MS), state(2 * MS, 1 * MS)])
    node.step(2 * MS, ())
    node.step(3 * MS, [lease(EPOCH), tick(3 * MS, {})])
    node.step(4 * MS, [state(3 * MS, 4 * MS)])

    assert source.seen == [2, 3]
    assert source.seen_when_asked == [0, 1, 1, 1, 2]


def test_reordered_state_is_not_observed() -> None:
    source = Onlooker()
    node = OperatorNode(source, epoch=EPOCH)
    older, newer = state(5 * MS, 7 * MS), state(6 * MS, 6 * MS)  # numbered in this order
    node.step(6 * MS, [newer])
    node.step(7 * MS, [older])

    assert source.seen == [6]


def test_keys_reach_the_wire() -> None:
    keys = [[Key.LEFT]]
    source = Keyboard(authority=10.0, inputs=2, keys=lambda: keys.pop() if keys else [])
    node = OperatorNode(source, epoch=EPOCH)
    node.step(50 * MS, ())
    (outgoing,) = node.step(150 * MS, ())
    body = outgoing[1]
    assert isinstance(body, OperatorCommand)
    assert body.u_h == pytest.approx((-10 * (1 - exp(-0.1 / RAMP_S)), 0.0))
    assert (body.enabled, body.device) == (True, "keyboard")


def test_quitting_sends_a_released_zero_and_tells_the_driver() -> None:
    keys = [[Key.QUIT], [Key.LEFT]]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)
    node.step(0, ())
    assert not node.finished
    (outgoing,) = node.step(MS, ())
    assert outgoing[1] == OperatorCommand((0.0, 0.0), (0.0, 0.0), False, "keyboard")
    assert node.finished
