"""The operator node beside others: who drives when there are two."""

import pytest
from passafe_protocol.messages import (
    Event,
)
from passafe_protocol.topics import COMMAND, EVENT
from passafe_services.operator.keyboard.keyboard import Keyboard
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.node import OperatorNode
from stepped_operator import EPOCH, TimeTeller, lease


@pytest.mark.parametrize("holder", [0, EPOCH])
def test_a_free_lease_and_its_own_silence_no_node(holder: int) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    for step in range(5):
        (outgoing,) = node.step(step, [lease(holder)])
        assert outgoing[0] is COMMAND
        assert outgoing[1].take_over == 0


@pytest.mark.parametrize("other", [EPOCH - 1, EPOCH + 1])
def test_the_second_operator_sends_nothing_and_says_so_once(other: int) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert node.step(0, ())[0][0] is COMMAND

    (outgoing,) = node.step(1, [lease(other)])

    assert outgoing == (
        EVENT,
        Event("warning", f"operator session {EPOCH} sends nothing: session {other} (other) holds the lease"),
    )
    for step in range(2, 50):
        assert list(node.step(step, [lease(other)] if step % 2 else [])) == []


def test_a_waiting_operator_follows_when_the_lease_is_free() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    node.step(0, [lease(7)])

    event, command = node.step(1, [lease(0)])

    assert event == (EVENT, Event("info", f"operator session {EPOCH} waits no longer"))
    assert command[0] is COMMAND
    assert [out[0] for out in node.step(2, [lease(EPOCH)])] == [COMMAND]


def test_a_take_over_names_the_lease_until_it_is_granted() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH, takes_over=True)

    inboxes = [[], [lease(7, number=3)], [], [lease(EPOCH, number=4)], [], [lease(7, number=5)], []]
    sent = [[out[1].take_over for out in node.step(k, inbox) if out[0] is COMMAND] for k, inbox in enumerate(inboxes)]

    assert sent == [[0], [3], [3], [0], [0], [], []]  # asked once: whoever takes over in turn keeps it


def test_a_key_takes_the_lease_over() -> None:
    keys = [[], [Key.TAKE_OVER], [], [Key.TAKE_OVER], []]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)

    sent = [node.step(k, inbox) for k, inbox in enumerate([[], [], [lease(7, number=2)], [], []])]

    requested = [[out[1].take_over for out in outgoing if out[0] is COMMAND] for outgoing in sent]
    assert requested == [[0], [0], [], [2], [2]]
