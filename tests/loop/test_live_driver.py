"""The live driver in real processes."""

import os
import re
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Event, Header, Health, LinkEvent, Message
from passafe_protocol.topics import COMMAND, TOPIC_OF_NAME
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint

pytestmark = [pytest.mark.live, pytest.mark.alone]

PATIENCE_S = 20.0
LoggedMessage = list[tuple[Header, Message]]


class Log:
    """Messages received by a recorder, decoded, by key."""

    def __init__(self, bus: Bus) -> None:
        self._reader = bus.recording_reader()
        self.received: dict[str, LoggedMessage] = {}

    def wait_for(self, key: str, enough: Callable[[LoggedMessage], bool]) -> LoggedMessage:
        """Return the messages of a key once there are enough."""
        end = time.monotonic() + PATIENCE_S
        while not enough(self.received.get(key, [])):
            assert time.monotonic() < end, {name: len(logged) for name, logged in self.received.items()}
            for name, data in self._reader.drain():
                topic = TOPIC_OF_NAME[name.rpartition("/")[2]]
                with suppress(ProtocolError):
                    self.received.setdefault(name, []).append(decode(topic, data))
            time.sleep(0.005)
        return self.received[key]


@pytest.fixture
def bus(router: object, port: int) -> Iterator[Bus]:
    del router
    with open_bus(RouterEndpoint(port=port)) as bus:
        yield bus


@pytest.fixture
def log(bus: Bus) -> Log:
    return Log(bus)


def test_header_has_due_and_start_time_of_the_step(start: Callable, port: int, log: Log) -> None:
    operator = start("operator", "--port", port, "--steps", 300, "--epoch", 77)
    operator.wait_ready("operator")
    logged = log.wait_for("passafe/robot/operator/command", lambda logged: len(logged) == 300)
    assert operator.output()["reason"] == "FINISHED"
    first = logged[0][0].scheduled_ns
    for sequence, (header, body) in enumerate(logged):
        assert header.source == "operator"
        assert header.epoch == 77
        assert header.sequence == sequence
        assert body.u_h == (float(sequence), float(header.scheduled_ns))
        assert header.scheduled_ns < header.started_ns < header.sent_ns
        assert (header.scheduled_ns - first) % 1_000_000 == 0
    # Later ones would have been skipped; but the clock is read again once the inlets are drained.
    assert sum(header.started_ns - header.scheduled_ns >= 1_000_000 for header, _ in logged) <= 3


def test_a_message_is_received_when_its_step_begins(start: Callable, port: int, log: Log) -> None:
    start("filter", "--port", port).wait_ready("filter")
    start("operator", "--port", port, "--steps", 300).wait_ready("operator")
    logged = log.wait_for("passafe/robot/filter/input", lambda logged: len(logged) >= 300)
    commands = log.wait_for("passafe/robot/operator/command", lambda logged: len(logged) == 300)
    sent_ns = {header.sequence: float(header.sent_ns) for header, _ in commands}
    for header, body in logged:
        sequence, received_ns, now_ns, was_sent_ns = body.u
        assert now_ns == float(header.scheduled_ns)
        assert received_ns == float(header.started_ns)
        assert was_sent_ns == sent_ns[int(sequence)]


def test_a_link_delays_and_drops_and_tells(start: Callable, port: int, log: Log) -> None:
    start("filter", "--port", port, "--delay", 0.05, "--loss", 0.5).wait_ready("filter")
    start("operator", "--port", port, "--steps", 400).wait_ready("operator")
    received = log.wait_for("passafe/robot/filter/input", lambda logged: len(logged) >= 100)
    for header, body in received:
        _, received_ns, _, was_sent_ns = body.u
        assert received_ns <= header.started_ns
        assert received_ns - was_sent_ns >= 50e6 - 1e3  # floats of 2⁵⁰ ns and more
    dropped = log.wait_for("passafe/robot/filter/link_event", lambda logged: len(logged) >= 100)
    assert {event.effect for _, event in dropped} == {"dropped"}
    came = {int(body.u[0]) for _, body in received}
    assert came.isdisjoint(event.sequence for _, event in dropped)


def test_nothing_is_received_before_it_was_sent(start: Callable, port: int, log: Log) -> None:
    start("filter", "--port", port, "--held-up", 0.02).wait_ready("filter")
    start("operator", "--port", port, "--steps", 400).wait_ready("operator")
    received = log.wait_for("passafe/robot/filter/input", lambda logged: len(logged) >= 300)
    for header, body in received:
        _, received_ns, _, was_sent_ns = body.u
        assert was_sent_ns <= received_ns == float(header.started_ns)


def test_garbage_is_counted_and_reported_once(start: Callable, port: int, bus: Bus, log: Log) -> None:
    echo = start("filter", "--port", port)
    echo.wait_ready("filter")
    put = bus.publisher(COMMAND, "operator")
    for garbage in (b"", b"\xff" * 40, b"\x00", os.urandom(200), b"{}"):
        put(garbage)
    events = log.wait_for("passafe/robot/filter/event", lambda logged: any("refused" in e.text for _, e in logged))
    assert [event for _, event in events if event.severity == "warning" and "refused" in event.text]
    health = log.wait_for("passafe/robot/filter/health", lambda logged: logged and logged[-1][1].topics[0].refused >= 5)
    assert health[-1][1].topics[0].topic == "command"
    start("operator", "--port", port, "--steps", 5).wait_ready("operator")
    log.wait_for("passafe/robot/filter/input", lambda logged: len(logged) >= 5)
    os.kill(echo.pid, signal.SIGTERM)
    assert echo.output()["reason"] == "SIGNAL"
    code, errors = echo.end()
    assert code == 0
    assert errors.count("warning: refused") == 1


def test_what_is_not_finite_does_not_leave(start: Callable, port: int, log: Log) -> None:
    operator = start("operator", "--port", port, "--steps", 100, "--non-finite")
    operator.wait_ready("operator")
    output = operator.output()
    assert output["withheld"] == 10
    logged = log.wait_for("passafe/robot/operator/command", lambda logged: len(logged) == 90)
    assert [header.sequence for header, _ in logged] == list(range(90))
    _, errors = operator.end()
    assert errors.count("error: withheld command.u_h") == 1


def test_health_is_published_once_a_second(start: Callable, port: int, log: Log) -> None:
    operator = start("operator", "--port", port, "--rate", 200, "--duration", 2.2)
    operator.wait_ready("operator")
    output = operator.output()
    assert output["reason"] == "DURATION"
    assert output["steps"] + output["missed"] == 440
    logged = log.wait_for("passafe/robot/operator/health", lambda logged: len(logged) == 3)
    healths = [health for _, health in logged]
    assert all(isinstance(health, Health) for health in healths)
    assert healths[-1].steps == output["steps"]
    assert healths[-1].steps_skipped == output["missed"]
    assert healths[0].rate_hz == pytest.approx(
        200.0 * healths[0].steps / (healths[0].steps + healths[0].steps_skipped), rel=0.05
    )
    events = log.wait_for("passafe/robot/operator/event", lambda logged: any("ended by" in e.text for _, e in logged))
    assert Event("info", f"ended by end of its duration after {output['steps']} steps") in [e for _, e in events]


def test_overload_is_reported(start: Callable, port: int, log: Log) -> None:
    """A step in a microsecond is too much; nothing is sent but what is to be looked at, so nothing of it is lost."""
    idle = start("filter", "--port", port, "--rate", 1_000_000, "--duration", 1.2)
    idle.wait_ready("filter")
    logged = log.wait_for("passafe/robot/filter/event", lambda logged: any("ended by" in e.text for _, e in logged))
    [reported] = [event for _, event in logged if "skipped" in event.text]
    numbers = re.match(r"skipped (\d+) of the last (\d+) steps", reported.text)
    assert reported.severity == "warning"
    assert numbers is not None
    left_out, steps = int(numbers[1]), int(numbers[2])
    assert 990_000 < steps < 3_000_000  # those of a second, or a little more where the machine is busy
    assert 0.5 * steps < left_out < steps


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_cleanly(start: Callable, router: object, port: int, signum: int) -> None:
    del router
    operator = start("operator", "--port", port)
    operator.wait_ready("operator")
    os.kill(operator.pid, signum)
    assert operator.output()["reason"] == "SIGNAL"
    assert operator.end()[0] == 0


@pytest.mark.usefixtures("router")
def test_the_end_of_the_lifeline_ends_it_cleanly(start: Callable, port: int) -> None:
    operator = start("operator", "--port", port, "--lifeline")
    operator.wait_ready("operator")
    operator.cut_lifeline()
    assert operator.output()["reason"] == "LIFELINE"
    assert operator.end()[0] == 0


def test_no_router_is_one_clear_error(start: Callable, port: int) -> None:
    operator = start("operator", "--port", port)
    assert operator.output()["fault"] == "BusError"
    code, errors = operator.end()
    assert code == 2
    assert "Traceback" not in errors


def test_start_and_router_restart_are_reported(start: Callable, port: int) -> None:
    first = start("router", "--port", port)
    first.wait_ready("router")
    with open_bus(RouterEndpoint(port=port)) as bus:
        log = Log(bus)
        operator = start("operator", "--port", port, "--lifeline")
        operator.wait_ready("operator")
        log.wait_for("passafe/robot/operator/event", lambda logged: Event("info", "started") in [e for _, e in logged])
        os.kill(first.pid, signal.SIGKILL)
        first.end()
        start("router", "--port", port).wait_ready("router")
        again = "the router was restarted: messages sent in between were not delivered"
        reported = log.wait_for("passafe/robot/operator/event", lambda logged: any(e.text == again for _, e in logged))
        assert [e.text for _, e in reported].count(again) == 1
        operator.cut_lifeline()
        assert again in operator.end()[1]


def test_error_that_ends_a_node_stands_in_the_log(start: Callable, port: int, log: Log) -> None:
    operator = start("operator", "--port", port, "--broken-at", 50)
    operator.wait_ready("operator")

    said = "ended by an error after 50 steps: ValueError: no such stick"
    log.wait_for("passafe/robot/operator/event", lambda logged: Event("error", said) in [e for _, e in logged])
    assert operator.output()["ended"] == 50
    assert operator.end()[0] == 1


def test_link_events_are_link_events(start: Callable, port: int, log: Log) -> None:
    start("filter", "--port", port, "--loss", 1.0).wait_ready("filter")
    start("operator", "--port", port, "--steps", 20).wait_ready("operator")
    dropped = log.wait_for("passafe/robot/filter/link_event", lambda logged: len(logged) == 20)
    assert [event for _, event in dropped] == [
        LinkEvent("operator-to-filter", "dropped", "command", sequence, "loss") for sequence in range(20)
    ]


def test_error_before_the_first_step_stands_in_the_log(start: Callable, port: int, log: Log) -> None:
    operator = start("operator", "--port", port, "--broken-at", -1)

    said = "ended by an error before its first step: ValueError: no stick"
    log.wait_for("passafe/robot/operator/event", lambda logged: Event("error", said) in [e for _, e in logged])
    assert operator.end()[0] == 1


def test_call_that_does_not_return_ends_the_process(start: Callable, port: int, log: Log) -> None:
    operator = start("operator", "--port", port, "--hangs-at", 50)
    operator.wait_ready("operator")

    said = "ended: stick: move: got no return for 2 s, allowed to return at once"
    log.wait_for("passafe/robot/operator/event", lambda logged: Event("error", said) in [e for _, e in logged])
    assert operator.end()[0] == 2


def test_call_that_takes_long_is_reported(start: Callable, port: int, log: Log) -> None:
    start("operator", "--port", port, "--hangs-at", 50, "--hangs-s", 1).wait_ready("operator")

    said = "stick: move: got no return for 0.2 s, allowed to return at once"
    log.wait_for("passafe/robot/operator/event", lambda logged: Event("warning", said) in [e for _, e in logged])
