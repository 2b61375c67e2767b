"""The operator node with a page that drives."""

import pytest
from passafe_protocol.messages import (
    OperatorCommand,
    Received,
    Steer,
)
from passafe_protocol.topics import COMMAND, STEER
from passafe_services.operator.node import OperatorNode
from passafe_services.operator.page.page_driver import PageDriver
from passafe_services.operator.sources.source import SourceClock
from stepped_operator import EPOCH, MS, TimeTeller, lease, received, state, stopped


def steer(
    at_ns: int, driver: str = "page", *, engaged: bool = True, turn: int = 1, take_over: bool = False
) -> Received:
    page = 3 if driver == "page" else 0
    shares = (0.5,) if page else ()
    body = Steer(turn, driver, page, shares, engaged, 0, take_over, EPOCH, at_ns, 0)
    return received(body, at_ns, source="dashboard")


def with_page(clock: SourceClock = SourceClock.PLANT) -> OperatorNode:
    return OperatorNode(TimeTeller(clock=clock), epoch=EPOCH, page=PageDriver((8.0,), epoch=EPOCH))


def sent(node: OperatorNode, now_ns: int, *inbox: Received) -> OperatorCommand:
    [command] = [body for topic, body in node.step(now_ns, inbox) if topic is COMMAND]
    assert isinstance(command, OperatorCommand)
    return command


def test_a_page_takes_the_place_of_the_script_and_hands_back() -> None:
    node = with_page()
    assert STEER in node.subscribes
    assert sent(node, MS, state(5 * MS, MS)).device == "teller"
    assert sent(node, 2 * MS, steer(2 * MS)).enabled
    driven = sent(node, 30 * MS)
    assert (driven.device, driven.enabled) == ("page", True)
    assert 0.0 < driven.u_h[0] < 4.0
    free = sent(node, 31 * MS, steer(31 * MS, "nobody", turn=2))
    assert (free.device, free.enabled, free.u_h) == ("page", False, (0.0,))
    back = sent(node, 35 * MS, steer(35 * MS, "script", turn=3))
    assert (back.device, back.u_h) == ("teller", (pytest.approx(0.039),))


def test_without_a_page_nothing_is_read_of_one() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert STEER not in node.subscribes
    assert sent(node, MS, steer(MS)).device == "teller"


def test_a_page_takes_the_lease_over_once() -> None:
    node = with_page()
    assert not [body for topic, body in node.step(MS, [lease(77, number=4)]) if topic is COMMAND]
    assert not [body for topic, body in node.step(2 * MS, [steer(2 * MS)]) if topic is COMMAND]
    assert sent(node, 3 * MS, steer(3 * MS, turn=2, take_over=True)).take_over == 4
    assert sent(node, 4 * MS, lease(EPOCH, number=5)).take_over == 0
    node.step(5 * MS, [lease(77, number=6), steer(5 * MS, turn=2, take_over=True)])
    assert not [body for topic, body in node.step(6 * MS, ()) if topic is COMMAND]


def test_a_page_has_to_let_go_after_an_emergency_stop() -> None:
    node = with_page()
    sent(node, MS, steer(MS))
    assert not sent(node, 2 * MS, stopped(2 * MS, stop=9)).enabled
    assert not sent(node, 3 * MS, stopped(3 * MS, stop=0), steer(3 * MS)).enabled
    assert not sent(node, 4 * MS, steer(4 * MS, engaged=False)).enabled
    assert sent(node, 5 * MS, steer(5 * MS)).enabled
