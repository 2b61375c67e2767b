"""A page at the wheel of the operator: only what is fresh, in order, held and of this turn drives."""

from math import exp
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol.messages import Header, Received, Steer
from passafe_services.operator.page.page_driver import FOLLOW_S, FRESH_NS, PageDriver

MS = 1_000_000
EPOCH = 7
START_NS = 10_000 * MS


class Page:
    """A dashboard that steers a driver, in the driver's own time."""

    def __init__(self) -> None:
        self.driver = PageDriver((10.0, 4.0), epoch=EPOCH)
        self.sequence = 0

    def send(self, at_ms: float, *, way_ms: float = 1.0, term: int = 0, **fields: Any) -> None:  # noqa: ANN401 - of Steer
        """Let a message arrive that took ``way_ms`` after an echo of the command of ``at_ms``."""
        now_ns = START_NS + round(at_ms * MS)
        sequence = fields.pop("sequence", self.sequence)
        self.sequence = sequence + 1
        known = {"turn": 1, "driver": "page", "page": 3, "shares": (1.0, -0.5), "engaged": True}
        echo = {"echoed_epoch": EPOCH, "echoed_ns": now_ns - round(way_ms * MS), "echoed_for_ns": 0}
        steer = Steer(**(known | echo | fields))
        header = Header("dashboard", 1, sequence, 0, 0, 0, 0)
        self.driver.receive(Received(header, steer, now_ns, term), steer)

    def u_h(self, at_ms: float) -> tuple[float, ...] | None:
        """Return the command at a time, ``None`` if it is released."""
        command = self.driver.command(START_NS + round(at_ms * MS))
        if command.enabled:
            return command.u_h
        assert command.u_h == command.u_h_rate == (0.0, 0.0)
        return None


def test_the_source_drives_until_a_page_does() -> None:
    page = Page()
    assert not page.driver.commands

    page.send(0)
    assert page.driver.commands

    page.send(1, turn=2, driver="nobody", page=0, shares=(), engaged=False)
    assert page.driver.commands  # nobody: a released zero, not the source
    assert page.u_h(1) is None

    page.send(2, turn=3, driver="script", page=0, shares=(), engaged=False)
    assert not page.driver.commands


def test_a_command_is_followed_smoothly_with_its_rate() -> None:
    page = Page()
    page.send(0)
    assert page.u_h(0) == (0.0, 0.0)

    left = exp(-0.01 / FOLLOW_S)
    assert page.u_h(10) == pytest.approx((10.0 * (1 - left), -2.0 * (1 - left)))
    assert page.driver.command(START_NS + 10 * MS).u_h_rate == pytest.approx(
        (10.0 * left / FOLLOW_S, -2.0 * left / FOLLOW_S)
    )


def test_it_is_fresh_for_a_quarter_of_a_second_since_it_was_made() -> None:
    page = Page()
    page.send(0, way_ms=30.0, age_ns=20 * MS)
    assert page.u_h(200) is not None
    assert page.u_h(200.001) is None


def test_a_command_without_our_echo_does_not_drive() -> None:
    page = Page()
    page.send(0, echoed_epoch=EPOCH + 1)
    assert page.u_h(0) is None
    page.send(1)
    assert page.u_h(1) is not None


def test_after_a_pause_the_dead_man_has_to_be_let_go() -> None:
    page = Page()
    page.send(0)
    assert page.u_h(249) is not None
    assert page.u_h(251) is None

    page.send(260)
    assert page.u_h(260) is None  # still held: the robot does not start by itself
    page.send(270, engaged=False)
    assert page.u_h(270) is None
    page.send(280)
    assert page.u_h(280) is not None


def test_another_turn_needs_no_release() -> None:
    page = Page()
    page.send(0)
    page.u_h(0)
    assert page.u_h(300) is None
    page.send(310, turn=2, page=4)
    assert page.u_h(310) is not None


def test_reordered_and_repeated_messages_change_nothing() -> None:
    page = Page()
    page.send(0, sequence=5)
    page.send(1, sequence=4, engaged=False)
    page.send(2, sequence=5, turn=2, driver="nobody", page=0, shares=(), engaged=False)
    assert page.u_h(3) is not None


def test_a_restarted_dashboard_counts() -> None:
    page = Page()
    page.send(0, sequence=500)
    page.send(1, sequence=0, term=1, driver="nobody", page=0, shares=(), engaged=False)
    assert page.u_h(1) is None


def test_a_turn_asks_for_the_lease_once() -> None:
    page = Page()
    for at_ms in range(3):
        page.send(at_ms, take_over=True)
    assert page.driver.take_overs == 1
    page.send(4, turn=2, take_over=True)
    assert page.driver.take_overs == 2


def test_a_command_of_other_axes_does_not_drive() -> None:
    page = Page()
    page.send(0, shares=(1.0,))
    assert page.u_h(0) is None


messages = st.lists(
    st.fixed_dictionaries(
        {
            "gap_ms": st.floats(0.0, 400.0),
            "way_ms": st.floats(0.0, 400.0),
            "age_ns": st.integers(0, 400 * MS),
            "engaged": st.booleans(),
            "echoed_epoch": st.sampled_from([EPOCH, EPOCH, EPOCH + 1]),
            "late": st.integers(0, 3),
            "driver": st.sampled_from(["page", "page", "nobody"]),
            "shares": st.lists(st.floats(-1, 1), min_size=0, max_size=3).map(tuple),
        }
    ),
    max_size=12,
)


@given(messages)
def test_only_a_fresh_held_command_in_order_drives(steps: list[dict[str, Any]]) -> None:
    page, now_ms, sequence = Page(), 0.0, 10
    newest: dict[str, Any] = {}
    for step in steps:
        now_ms += step["gap_ms"]
        fields = {name: step[name] for name in ("way_ms", "age_ns", "engaged", "echoed_epoch", "driver", "shares")}
        sequence += 1 - step["late"]
        if not newest or sequence > newest["sequence"]:
            newest = fields | {"sequence": sequence, "at_ms": now_ms}
        page.send(now_ms, sequence=sequence, page=3 if step["driver"] == "page" else 0, **fields)
        for later_ms in (now_ms, now_ms + 120.0):
            u_h = page.u_h(later_ms)
            age_ms = later_ms - newest["at_ms"] + newest["way_ms"] + newest["age_ns"] / MS
            may = newest["driver"] == "page" and newest["engaged"] and newest["echoed_epoch"] == EPOCH
            if u_h is not None:
                assert may
                assert len(newest["shares"]) == 2
                assert age_ms <= FRESH_NS / MS + 1e-5
                assert abs(u_h[0]) <= 10.0
                assert abs(u_h[1]) <= 4.0
        now_ms += 120.0
