"""The operator node and emergency stops."""

from passafe_protocol.topics import COMMAND, STOP
from passafe_services.operator.keyboard.keyboard import Keyboard
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.node import OperatorNode
from passafe_services.operator.sources.lag import Lag
from stepped_operator import EPOCH, MS, lease, stopped


def test_the_stop_is_pressed_until_a_state_names_it() -> None:
    keys = [[], [], [], [], [Key.EMERGENCY_STOP], [Key.LEFT]]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=lambda: keys.pop() if keys else []), epoch=EPOCH)
    node.step(0, ())
    presses = [out[1] for k in range(1, 30) for out in node.step(k * MS, ()) if out[0] is STOP]

    assert len(presses) == 3  # at 1, 11 and 21 ms
    assert len(set(presses)) == 1
    named = stopped(30 * MS, stop=presses[0].id)
    assert [out[0] for k in range(30, 60) for out in node.step(k * MS, [named] if k == 30 else [])] == [COMMAND] * 30


def test_presses_have_ids_of_their_own() -> None:
    keys = [[Key.EMERGENCY_STOP] for _ in range(3)]
    sources = [Keyboard(authority=1.0, inputs=2, keys=lambda: keys[0]) for _ in range(2)]
    nodes = [OperatorNode(source, epoch=epoch) for source, epoch in zip(sources, (EPOCH, 2**64 - 1), strict=True)]
    found = [node.step(k * MS, ())[0][1].id for node in nodes for k in range(3)]

    assert len(set(found)) == 6


def test_a_stop_releases_a_scripts_dead_man_until_the_clear() -> None:
    node = OperatorNode(Lag(target=(-3.0, 0.0), time_constant_s=0.2), epoch=EPOCH)
    inboxes = [[], [stopped(1, stop=5)], [], [stopped(3, stop=0)]]

    sent = [node.step(k, inbox)[-1][1] for k, inbox in enumerate(inboxes)]

    assert [command.enabled for command in sent] == [True, False, False, True]
    assert (sent[1].u_h, sent[1].u_h_rate) == ((0.0, 0.0), (0.0, 0.0))


def test_a_person_lets_go_once_after_a_stop() -> None:
    held = [[Key.LEFT]] * 3 + [[]] * 200 + [[Key.LEFT]]
    node = OperatorNode(Keyboard(authority=9.0, inputs=2, keys=lambda: held.pop(0) if held else []), epoch=EPOCH)
    inboxes = {1: [stopped(1, stop=5)], 2: [stopped(2, stop=0)]}

    enabled = [node.step(k * 10 * MS, inboxes.get(k, []))[-1][1].enabled for k in range(205)]

    assert enabled[0]
    assert not any(enabled[1:203])  # the key counts as held for a while after the clear
    assert enabled[203]


def test_a_silenced_person_can_still_quit() -> None:
    keys = [[Key.QUIT], [], []]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)
    node.step(0, [lease(7)])
    node.step(1, ())
    assert not node.finished
    assert list(node.step(2, ())) == []
    assert node.finished
