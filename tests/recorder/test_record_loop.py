"""The recorder's loop, with a clock of the test's own."""

import errno
import os
from pathlib import Path

import pytest
from logged_sequences import sequences
from mcap.records import Footer
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, Health, Message, Receipt, RecordedSession
from passafe_protocol.topics import EVENT, HEALTH, RECEIPT, Topic
from passafe_services.log.chain import Chain
from passafe_services.log.errors import LogWriteError
from passafe_services.log.log_reader import LogReader
from passafe_services.log.segmented_log import SegmentedLog
from passafe_services.recorder.background_log import BackgroundLog
from passafe_services.recorder.record_loop import record

S = 1_000_000_000
MS = 1_000_000


def made(number: int) -> tuple[str, bytes]:
    """Return the key and the bytes of a message."""
    header = Header("plant", 1, number, 0, 0, 0, number * 10 * MS)
    return EVENT.key("plant"), encode(header, Event("info", "x"))


class Answer:
    """Answer of a cache that has ended."""

    has_ended = True

    def __init__(self, samples: list[tuple[str, bytes]]) -> None:
        self.samples = samples

    def drain(self) -> list[tuple[str, bytes]]:
        """Return all of it."""
        return self.samples


class Desk:
    """Clock, bus and stop request of a recorder under test: a message every 10 ms, all but 7 and 8.

    The cache of their publisher is asked in vain, or only so often.
    """

    def __init__(self, *, stop_after_s: float, late_messages: int = 0, asked_in_vain: int | None = None) -> None:
        self.now_ns = 0
        self.stop_ns = int(stop_after_s * S)
        self.late_messages = late_messages
        self.asked_in_vain = asked_in_vain
        self.asked: list[tuple[str, int, int]] = []
        self.made = 0
        self.published: list[tuple[Topic, Message]] = []
        self.log: BackgroundLog | None = None
        self.disk_answers = True

    def drain(self) -> list[tuple[str, bytes]]:
        """Return what was made since the last call."""
        newest = self.now_ns // (10 * MS) if self.now_ns < self.stop_ns else self.made + self.late_messages
        if self.now_ns >= self.stop_ns:
            self.late_messages = 0
        numbers = [k for k in range(self.made, newest) if k not in {7, 8}]
        self.made = max(newest, self.made)
        return [made(k) for k in numbers]

    def ask(self, key: str, first: int, last: int) -> Answer:
        """Ask the publisher's cache."""
        self.asked.append((key, first, last))
        answers = self.asked_in_vain is not None and len(self.asked) > self.asked_in_vain
        return Answer([made(k) for k in range(first, last + 1)] if answers else [])

    def wait(self, timeout_s: float | None = None) -> bool:
        """Let time pass."""
        assert timeout_s is not None
        if self.log is not None:
            self.log.wait_until_idle()
        self.now_ns += max(round(timeout_s * S), 1)
        return self.now_ns >= self.stop_ns

    def publish(self, topic: Topic, body: Message, _now_ns: int) -> None:
        """Keep it for the test."""
        self.published.append((topic, body))

    def run(self, log: SegmentedLog) -> None:
        """Record into ``log``, whose disk has done its work whenever time passes."""
        background = BackgroundLog(log, retry_s=0.01)
        self.log = background if self.disk_answers else None
        record(
            self,
            background,
            publish=self.publish,
            stop=self,
            pause=lambda seconds: self.wait(seconds) and None,
            monotonic_ns=lambda: self.now_ns,
            wall_ns=lambda: self.now_ns,
        )


def new_log(path: Path) -> SegmentedLog:
    return SegmentedLog(path, {}, Chain("test"))


def test_messages_in_flight_at_the_end_are_logged(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    desk = Desk(stop_after_s=1.0, late_messages=5)
    desk.run(new_log(path))
    assert sequences(path) == [k for k in range(desk.made) if k not in {7, 8}]
    assert desk.made >= 98 + 5
    assert desk.now_ns < 1.4 * S  # it does not wait for what does not come


def test_a_bus_that_never_falls_silent_does_not_keep_it(tmp_path: Path) -> None:
    desk = Desk(stop_after_s=0.1)

    def drain() -> list[tuple[str, bytes]]:
        return [(EVENT.key("plant"), b"")]

    desk.drain = drain  # type: ignore[method-assign]  # the one thing that differs
    desk.run(new_log(tmp_path / "run.mcap"))
    assert desk.now_ns < 1 * S


def test_health_every_second_and_a_warning_for_missing_messages(tmp_path: Path) -> None:
    desk = Desk(stop_after_s=3.5)
    desk.run(new_log(tmp_path / "run.mcap"))
    health = [body for topic, body in desk.published if topic is HEALTH]
    assert len(health) == 3
    assert all(isinstance(body, Health) for body in health)
    last = health[-1]
    assert isinstance(last, Health)
    assert last.rate_hz == pytest.approx(50, rel=0.03)
    [topic] = last.topics
    assert (topic.topic, topic.gaps, topic.refused) == ("event", 2, 0)
    assert topic.received == pytest.approx(298, abs=3)
    [warning] = [body for topic, body in desk.published if topic is EVENT]
    assert warning == Event("warning", "messages missing in the log so far: passafe/robot/plant/event 2")


def test_receipts_say_ten_times_a_second_what_it_has(tmp_path: Path) -> None:
    desk = Desk(stop_after_s=1.05, asked_in_vain=0)
    desk.run(new_log(tmp_path / "run.mcap"))
    receipts = [body for topic, body in desk.published if topic is RECEIPT]
    newest = [body.sessions[0].newest for body in receipts if isinstance(body, Receipt)]

    assert len(newest) == pytest.approx(10, abs=1)
    after = [number for number in newest if number != 6]  # the last one before those that are missing for a while
    assert newest == sorted(newest)
    assert len({*after}) == len(after) > 5
    last = receipts[-1]
    assert isinstance(last, Receipt)
    assert last.sessions == (RecordedSession("plant", "event", last.sessions[0].epoch, newest[-1]),)
    assert newest[-1] == pytest.approx(100, abs=12)


def test_messages_under_strange_keys_are_reported_once(tmp_path: Path) -> None:
    desk = Desk(stop_after_s=4.5)

    def drain() -> list[tuple[str, bytes]]:
        return [(f"passafe/robot/k{desk.now_ns}-{k}/health", b"123") for k in range(1_000)]

    desk.drain = drain  # type: ignore[method-assign]  # the one thing that differs
    desk.run(new_log(tmp_path / "run.mcap"))
    [warning] = [body for topic, body in desk.published if topic is EVENT]
    assert isinstance(warning, Event)
    assert warning.text.startswith("messages that are none of the topic table's, not logged so far: ")
    assert sequences(tmp_path / "run.mcap") == []


def test_a_cache_is_asked_until_it_answers(tmp_path: Path) -> None:
    desk = Desk(stop_after_s=3.0, asked_in_vain=4)
    desk.run(new_log(tmp_path / "run.mcap"))

    assert desk.asked == [(EVENT.key("plant"), 7, 8)] * 5
    assert sorted(sequences(tmp_path / "run.mcap")) == list(range(desk.made))
    assert LogReader(tmp_path / "run.mcap").shortcomings == []
    newest = [
        body.sessions[0].newest for topic, body in desk.published if topic is RECEIPT and isinstance(body, Receipt)
    ]
    waits = [number for number in newest if number == 6]
    assert newest[: len(waits)] == waits
    assert newest[len(waits)] > 100


def test_logged_messages_are_on_disk_within_a_quarter_second(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    desk = Desk(stop_after_s=2.0)
    worst_ns = 0
    log = new_log(path)

    def publish_and_look(seconds: float | None = None) -> bool:
        nonlocal worst_ns
        on_disk = sequences(path)
        worst_ns = max(worst_ns, desk.now_ns - (on_disk[-1] * 10 * MS if on_disk else 0))
        return Desk.wait(desk, seconds)

    desk.wait = publish_and_look  # type: ignore[method-assign]  # the same, with a look at the disk before
    desk.run(log)
    assert 100 * MS < worst_ns <= 200 * MS


def test_full_disk_is_reported_and_ends_no_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    desk = Desk(stop_after_s=5.0)
    path = tmp_path / "run.mcap"
    synchronize = os.fdatasync

    def full_for_a_while(descriptor: int) -> None:
        if 2 * S <= desk.now_ns < 3 * S and not failures.done():
            failures.failed += 1
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        synchronize(descriptor)

    failures = Failures(most=3)
    monkeypatch.setattr(os, "fdatasync", full_for_a_while)
    desk.run(new_log(path))
    texts = [body.text for topic, body in desk.published if topic is EVENT and isinstance(body, Event)]
    [full] = [text for text in texts if "No space left" in text]
    assert f"what was recorded before is in {path}" in full
    assert f"recording again, in {tmp_path / 'run.2.mcap'}" in texts
    assert sequences(path) == [k for k in range(desk.made) if k not in {7, 8}]
    reader = LogReader(path)
    assert [record for record in reader.records() if isinstance(record, Footer)]
    assert reader.finished
    assert reader.shortcomings == [f"messages that the recorder never received: 2 of {EVENT.key('plant')}"]


def test_a_disk_that_stays_full_is_an_error_in_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    desk = Desk(stop_after_s=2.0)
    desk.disk_answers = False
    log = new_log(tmp_path / "run.mcap")

    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fdatasync", full)
    with pytest.raises(LogWriteError, match="No space left"):
        desk.run(log)
    severities = [body.severity for topic, body in desk.published if topic is EVENT and isinstance(body, Event)]
    assert "error" in severities
    assert [path.name for path in tmp_path.iterdir()] == ["run.mcap"]


class Failures:
    """Number of writes that were refused, and how many are to be."""

    def __init__(self, most: int) -> None:
        self.failed = 0
        self._most = most

    def done(self) -> bool:
        """Return whether all were refused."""
        return self.failed >= self._most
