"""The bus over a real router on loopback."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

import pytest
import zenoh
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import Header, OperatorCommand
from passafe_protocol.topics import COMMAND, INPUT, LINK_CONFIG, Topic
from passafe_services.loop.bus import Bus, TopicReader, open_bus
from passafe_services.loop.errors import BusError, PublisherError
from passafe_services.loop.recording_reader import RecordingReader
from passafe_services.loop.router_endpoint import RouterEndpoint

pytestmark = [pytest.mark.live, pytest.mark.alone]

PATIENCE_S = 20.0


@pytest.fixture
def endpoint(router: object, port: int) -> RouterEndpoint:
    del router
    return RouterEndpoint(port=port)


@pytest.fixture
def sender(endpoint: RouterEndpoint) -> Iterator[Bus]:
    with open_bus(endpoint) as bus:
        yield bus


@pytest.fixture
def receiver(endpoint: RouterEndpoint) -> Iterator[Bus]:
    with open_bus(endpoint) as bus:
        yield bus


def collect(drain: Callable[[], list], number: int) -> list:
    """At least ``number`` items from a reader, in bounded time."""
    got: list = []
    end = time.monotonic() + PATIENCE_S
    while len(got) < number:
        assert time.monotonic() < end, f"{len(got)} of {number} came"
        got += drain()
        time.sleep(0.001)
    return got


def message(sequence: int) -> bytes:
    header = Header("operator", 1, sequence, 0, 0, 0, 0)
    return encode(header, OperatorCommand((float(sequence),), (), enabled=True, device="test"))


def wait_for_reader(put: Callable[[bytes], None], reader: TopicReader | RecordingReader) -> None:
    """Until what is put arrives: a declaration takes a moment to reach the other side."""
    end = time.monotonic() + PATIENCE_S
    while not reader.drain():
        assert time.monotonic() < end
        put(b"are you there?")
        time.sleep(0.01)
    while reader.drain():
        time.sleep(0.05)


def test_what_is_put_arrives_in_order(sender: Bus, receiver: Bus) -> None:
    reader = receiver.reader(COMMAND)
    put = sender.publisher(COMMAND, "operator")
    wait_for_reader(put, reader)
    for sequence in range(100):
        put(message(sequence))
    got = collect(reader.drain, 100)
    assert got == [message(sequence) for sequence in range(100)]
    assert sender.connected


def test_a_full_ring_keeps_the_newest(sender: Bus, receiver: Bus) -> None:
    reader = receiver.reader(LINK_CONFIG)
    marker = receiver.reader(COMMAND)
    put = sender.publisher(LINK_CONFIG, "console")
    put_marker = sender.publisher(COMMAND, "operator")
    wait_for_reader(put, reader)
    wait_for_reader(put_marker, marker)
    for number in range(100):
        put(str(number).encode())
    put_marker(b"all were sent")
    collect(marker.drain, 1)
    assert reader.drain() == [str(number).encode() for number in range(100 - LINK_CONFIG.queue, 100)]


def test_session_does_not_receive_its_own_messages(sender: Bus, receiver: Bus) -> None:
    own, others = sender.reader(COMMAND), receiver.reader(COMMAND)
    put = sender.publisher(COMMAND, "operator")
    wait_for_reader(put, others)
    put(b"x")
    collect(others.drain, 1)
    assert own.drain() == []


def test_recording_reader_receives_every_topic_with_its_key(sender: Bus, receiver: Bus) -> None:
    log = receiver.recording_reader()
    puts = {
        "passafe/robot/operator/command": sender.publisher(COMMAND, "operator"),
        "passafe/robot/filter/input": sender.publisher(INPUT, "filter"),
        "passafe/robot/console/link_config": sender.publisher(LINK_CONFIG, "console"),
    }
    for key, put in puts.items():
        put(key.encode())
    got = collect(log.drain, 3)
    assert sorted(got) == sorted((key, key.encode()) for key in puts)


def test_a_log_reader_is_given_what_it_lost(start: Callable, router: object, port: int, sender: Bus) -> None:
    """The recorder stands still for longer than the lease: its session is closed and samples are dropped."""
    del router
    recorder = start("recorder", "--port", port)
    recorder.wait_ready("recorder")
    put = sender.publisher(COMMAND, "operator")
    began = time.monotonic()
    for sequence in range(3000):
        if sequence == 200:
            os.kill(recorder.pid, signal.SIGSTOP)
        if sequence == 2000:
            os.kill(recorder.pid, signal.SIGCONT)
        put(message(sequence))
        time.sleep(max(0.0, began + 0.001 * (sequence + 1) - time.monotonic()))
    recorder.cut_lifeline()
    output = recorder.output()
    logged = output["passafe/robot/operator/command"]
    # On a busy machine the reader may discover the publisher a message late; from then on nothing is missing.
    assert logged == list(range(logged[0], 3000))
    assert logged[0] < 100
    assert len(output["ring"]) < 3000  # what was lost to a reader that nobody helps


def test_caches_answer_the_questions_of_a_log_reader(sender: Bus, receiver: Bus) -> None:
    log, put = receiver.recording_reader(), sender.publisher(COMMAND, "operator")
    for k in range(20):
        put(message(k))

    def answer(topic: Topic, source: str) -> list[tuple[str, bytes]]:
        question = log.ask(topic.key(source), 5, 8)
        found: list[tuple[str, bytes]] = []
        end = time.monotonic() + PATIENCE_S
        while not question.has_ended:
            assert time.monotonic() < end
            found += question.drain()
            time.sleep(0.001)
        return found

    assert answer(INPUT, "filter") == []
    end = time.monotonic() + PATIENCE_S
    while not (found := answer(COMMAND, "operator")):  # the declaration of a cache takes a moment
        assert time.monotonic() < end
    assert found == [(COMMAND.key("operator"), message(k)) for k in range(5, 9)]


def test_publisher_survives_a_router_outage(start: Callable, port: int) -> None:
    first = start("router", "--port", port)
    first.wait_ready("router")
    with open_bus(RouterEndpoint(port=port)) as sender, open_bus(RouterEndpoint(port=port)) as receiver:
        reader = receiver.reader(COMMAND)
        put = sender.publisher(COMMAND, "operator")
        wait_for_reader(put, reader)
        os.kill(first.pid, signal.SIGKILL)
        first.end()
        end = time.monotonic() + PATIENCE_S
        while sender.connected:
            assert time.monotonic() < end
            put(b"into the void")
        start("router", "--port", port).wait_ready("router")
        wait_for_reader(put, reader)


def put_for(put: Callable[[bytes], None], sequences: range) -> None:
    """At 1 kHz."""
    began = time.monotonic()
    for count, sequence in enumerate(sequences, start=1):
        put(message(sequence))
        time.sleep(max(0.0, began + 0.001 * count - time.monotonic()))


def test_full_recording_reader_does_not_block_closing(
    sender: Bus, endpoint: RouterEndpoint, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("passafe_services.loop.bus.RECORDING_QUEUE", 16)
    put = sender.publisher(COMMAND, "operator")
    with open_bus(endpoint) as receiver:
        wait_for_reader(put, receiver.recording_reader())
        put_for(put, range(500))
        begun = time.monotonic()

    assert time.monotonic() - begun < 5.0  # a session gives up after 10 s, with an error


def test_recording_reader_gets_messages_of_a_router_outage(start: Callable, port: int) -> None:
    first = start("router", "--port", port)
    first.wait_ready("router")
    recorder = start("recorder", "--port", port)
    recorder.wait_ready("recorder")
    with open_bus(RouterEndpoint(port=port)) as sender:
        put = sender.publisher(COMMAND, "operator")
        put_for(put, range(200))
        os.kill(first.pid, signal.SIGKILL)
        first.end()
        put_for(put, range(200, 2000))
        start("router", "--port", port).wait_ready("router")
        put_for(put, range(2000, 4000))
        recorder.cut_lifeline()
        assert recorder.output()["passafe/robot/operator/command"] == list(range(4000))


def test_a_long_message_is_not_dropped_for_its_length(sender: Bus, receiver: Bus) -> None:
    """A message of several batches follows one that is still in flight."""
    reader = receiver.reader(COMMAND)
    put = sender.publisher(COMMAND, "operator")
    wait_for_reader(put, reader)
    for _ in range(20):
        put(message(1))
        put(bytes(400_000))
        assert [len(data) for data in collect(reader.drain, 2)][1] == 400_000


def test_no_router_is_an_error_in_bounded_time(port: int) -> None:
    began = time.monotonic()
    text = rf"tcp/127.0.0.1:{port}: no router answered within 0.3 s"
    with pytest.raises(BusError, match=text), open_bus(RouterEndpoint(port=port), timeout_s=0.3):
        pass
    assert time.monotonic() - began < 5.0


def test_a_process_publishes_its_own_topics_only(sender: Bus) -> None:
    with pytest.raises(PublisherError, match="publisher of input: got 'operator', allowed filter"):
        sender.publisher(INPUT, "operator")


def test_readers_receive_nothing_of_another_robot(sender: Bus, endpoint: RouterEndpoint, receiver: Bus) -> None:
    with open_bus(endpoint, robot="other") as elsewhere:
        own, other = receiver.reader(COMMAND), elsewhere.reader(COMMAND)
        log = elsewhere.recording_reader()
        put, put_elsewhere = sender.publisher(COMMAND, "operator"), elsewhere.publisher(COMMAND, "operator")
        wait_for_reader(put, own)
        put(b"mine")
        put_elsewhere(b"theirs")
        assert collect(own.drain, 1)[-1] == b"mine"
        assert other.drain() == []
        assert log.drain() == [("passafe/other/operator/command", b"theirs")]  # a log has its own session's messages


def test_the_session_is_closed_after_an_exception(endpoint: RouterEndpoint) -> None:
    with suppress(ZeroDivisionError), open_bus(endpoint) as bus:
        raise ZeroDivisionError
    with pytest.raises(zenoh.ZError):
        bus.publisher(COMMAND, "operator")


def test_garbage_arrives_as_it_is(sender: Bus, receiver: Bus) -> None:
    reader = receiver.reader(COMMAND)
    put = sender.publisher(COMMAND, "operator")
    wait_for_reader(put, reader)
    put(b"\xff\x00garbage")
    put(message(3))
    garbage, good = collect(reader.drain, 2)
    assert garbage == b"\xff\x00garbage"
    assert decode(COMMAND, good)[0].sequence == 3
