"""WebSocket /drive over the real server: who may steer, what is refused, what a page that leaves leaves behind."""

import json
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import Any

import pytest
from passafe_dashboard.routes.drive import MAX_PAGES, MAX_REFUSED
from passafe_protocol.messages import Steer
from served_page import FastRun, ServedPage
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect


class Wheel:
    """A page's connection."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.clock_ms = 0.0
        self.number = 0

    def send(self, kind: str, **fields: object) -> None:
        """Send a message."""
        self.connection.send(json.dumps({"type": kind} | fields))

    def steer(self, **fields: object) -> None:
        """Send a command made now, as far as the clock tells."""
        self.number += 1
        known = {
            "number": self.number,
            "shares": [1.0, -0.5],
            "engaged": True,
            "echo_ms": self.clock_ms,
            "held_ms": 0.0,
        }
        self.send("steer", **(known | fields))

    def next(self, kind: str) -> dict[str, Any]:
        """Return the next message of a kind."""
        while True:
            message: dict[str, Any] = json.loads(self.connection.recv(timeout=30))
            if message["type"] == "clock":
                self.clock_ms = message["server_ms"]
            if message["type"] == kind:
                return message

    def farewell(self) -> tuple[int, str]:
        """Return why the server closes the connection."""
        with pytest.raises(ConnectionClosed) as closed:
            self.next("nothing")
        assert closed.value.rcvd is not None
        return closed.value.rcvd.code, closed.value.rcvd.reason

    def take(self, *, over: bool = False) -> None:
        """Take the wheel and wait until it is ours."""
        self.send("take", over=over)
        while not self.next("driver")["you"]:
            pass
        self.next("clock")


@contextmanager
def wheel(page: ServedPage, **options: Any) -> Iterator[Wheel]:  # noqa: ANN401 - of connect()
    with connect(f"ws://{page.host}/drive", compression=None, **options) as connection:
        yield Wheel(connection)


def published(run: FastRun, says: Callable[[Steer], bool]) -> Steer:
    """Wait until something is published."""
    while not says(message := run.steered.get(timeout=30)):
        pass
    return message


def test_a_page_takes_the_wheel_steers_and_gives_it_back(page: ServedPage, run: FastRun) -> None:
    with wheel(page) as mine:
        first = mine.next("driver")
        assert (first["page"], first["you"], first["driver"]) == ("1", False, None)
        mine.take()
        assert page.get("/api/status").json()["drive"]["driver"]["page"] == "1"

        mine.steer()
        steer = published(run, lambda m: m.engaged)
        assert (steer.driver, steer.page, steer.shares) == ("page", 1, (1.0, -0.5))
        assert 0 <= steer.age_ns < 250_000_000

        mine.send("release")
        assert mine.next("driver") == {
            "type": "driver",
            "page": "1",
            "you": False,
            "driver": None,
            "reason": "released",
        }
        assert published(run, lambda m: m.driver == "nobody").turn == steer.turn + 1

        mine.send("script")
        assert mine.next("driver")["reason"] == "handed to the script by page 1"
        assert published(run, lambda m: m.driver == "script").turn == steer.turn + 2


def test_closing_frees_the_wheel_at_once(page: ServedPage, run: FastRun) -> None:
    with wheel(page) as other:
        with wheel(page) as mine:
            mine.take()
            mine.steer()
            published(run, lambda m: m.engaged)
        while other.next("driver")["reason"] != "the page was closed":
            pass
        assert published(run, lambda m: m.driver == "nobody")


def test_a_silent_page_loses_the_wheel(page: ServedPage) -> None:
    with wheel(page) as mine:
        mine.take()
        mine.steer()
        lost = mine.next("driver")
        assert (lost["you"], lost["reason"]) == (False, "the page was silent")


def test_a_second_page_takes_over_when_it_says_so(page: ServedPage, run: FastRun) -> None:
    with wheel(page) as first, wheel(page) as second:
        first.take()
        second.send("take")
        while second.next("driver")["reason"] != "page 1 drives":
            pass
        second.take(over=True)
        lost = first.next("driver")
        assert (lost["you"], lost["reason"]) == (False, "taken by page 2")
        first.steer(shares=[0.25, 0.25])
        second.steer()
        steer = published(run, lambda m: m.engaged)
        assert (steer.page, steer.shares, steer.take_over) == (2, (1.0, -0.5), True)


def test_stale_and_repeated_commands_do_not_drive(page: ServedPage, run: FastRun) -> None:
    with wheel(page) as mine:
        mine.take()
        mine.steer(number=5, shares=[0.1, 0.0])
        published(run, lambda m: m.shares == (0.1, 0.0))
        mine.steer(number=6, shares=[0.9, 0.0], echo_ms=mine.clock_ms - 251.0)
        mine.steer(number=5, shares=[0.8, 0.0])
        mine.steer(number=4, shares=[0.7, 0.0])
        mine.steer(number=7, shares=[0.2, 0.0])
        assert published(run, lambda m: m.shares != (0.1, 0.0)).shares == (0.2, 0.0)


BAD: list[tuple[str, str]] = [
    ("{", "message"),
    ("[]", "message"),
    ('{"type": "fly"}', "message"),
    ('{"type": "take", "over": 1}', "take.over"),
    ('{"type": "take", "extra": 1}', "take.extra"),
    ('{"type": "release", "now": true}', "release.now"),
]
BAD_STEER: list[tuple[dict[str, Any], str]] = [
    ({"shares": [1.0]}, "steer.shares"),
    ({"shares": [1.0, 1.0000001]}, "steer.shares.1"),
    ({"shares": [1.0, "1"]}, "steer.shares.1"),
    ({"shares": [float("nan"), 0.0]}, "steer.shares.0"),
    ({"shares": [float("inf"), 0.0]}, "steer.shares.0"),
    ({"shares": [0.0] * 65}, "steer.shares"),
    ({"number": -1}, "steer.number"),
    ({"number": 2**53}, "steer.number"),
    ({"engaged": None}, "steer.engaged"),
    ({"held_ms": -1.0}, "steer.held_ms"),
    ({"held_ms": float("nan")}, "steer.held_ms"),
    ({"held_ms": 1e6}, "steer.echo_ms + held_ms"),
]


def test_a_bad_message_is_refused_by_name(page: ServedPage) -> None:
    with wheel(page) as mine:
        for text, what in BAD:
            mine.connection.send(text)
            assert mine.next("refused")["what"] == what


def test_a_bad_command_is_refused_and_does_not_drive(page: ServedPage, run: FastRun) -> None:
    for fields, what in BAD_STEER:
        with wheel(page) as mine:
            mine.take(over=True)
            mine.steer(**fields)
            assert mine.next("refused")["what"] == what
    while not run.steered.empty():
        assert not run.steered.get().engaged


def test_ten_refusals_close_the_connection(page: ServedPage) -> None:
    with wheel(page) as mine:
        for _ in range(MAX_REFUSED):
            mine.connection.send(b"bytes")
        assert mine.farewell() == (1008, "10 messages were refused")


def test_a_flood_closes_the_connection(page: ServedPage) -> None:
    with wheel(page) as mine:
        with suppress(ConnectionClosed):
            for _ in range(1000):
                mine.send("release")
        assert mine.farewell() == (1008, "more than 200 messages a second")


def test_an_oversized_message_closes_the_connection(page: ServedPage) -> None:
    with wheel(page) as mine:
        mine.send("take", over="x" * 5000)
        assert mine.farewell()[0] == 1009


def test_there_is_a_limit_of_pages(page: ServedPage) -> None:
    with ExitStack() as stack:
        for _ in range(MAX_PAGES):
            stack.enter_context(wheel(page)).next("driver")
        late = stack.enter_context(wheel(page))
        assert late.farewell() == (1013, "too many pages are open")


@pytest.mark.parametrize("headers", [{"Origin": "http://evil.example"}, {"Host": "evil.example"}])
def test_a_page_of_another_site_cannot_drive(page: ServedPage, headers: dict[str, str]) -> None:
    with pytest.raises(InvalidStatus), wheel(page, additional_headers=headers):
        pass


def test_the_wheel_is_not_turned_by_get(page: ServedPage) -> None:
    assert page.get("/drive").status_code == 404
