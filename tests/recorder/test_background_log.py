"""The thread that writes the log: a disk that is slow costs no message until too many wait, and those are counted."""

import os
from pathlib import Path
from threading import Event as Signal

import pytest
from mcap.records import Message
from passafe_services.log.chain import Chain
from passafe_services.log.log_reader import LogReader
from passafe_services.log.segmented_log import SegmentedLog
from passafe_services.recorder import background_log
from passafe_services.recorder.background_log import MESSAGE_BYTES, BackgroundLog

KEY = "passafe/robot/plant/event"
DATA = bytes(100)
PATIENCE_S = 30.0


class Disk:
    """Disk that does not answer until it is let go."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.asked, self.free = Signal(), Signal()
        self._synchronize = os.fdatasync
        monkeypatch.setattr(os, "fdatasync", self._wait)

    def _wait(self, descriptor: int) -> None:
        self.asked.set()
        assert self.free.wait(PATIENCE_S)
        self._synchronize(descriptor)


def write(log: BackgroundLog, first: int, last: int) -> None:
    for k in range(first, last):
        log.write(KEY, DATA, sequence=k, wall_ns=k)
    log.hand_over()


def sequences(path: Path) -> tuple[list[int], list[str]]:
    reader = LogReader(path)
    found = [record.sequence for record in reader.records() if isinstance(record, Message)]
    return found, reader.shortcomings


def test_a_slow_disk_keeps_nobody_from_logging(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = BackgroundLog(SegmentedLog(tmp_path / "run.mcap", {}, Chain("slow")))
    disk = Disk(monkeypatch)
    monkeypatch.setattr(background_log, "RETRY_S", 0.0)
    write(log, 0, 10)
    log.flush({})
    assert disk.asked.wait(PATIENCE_S)
    for k in range(1, 20):  # the thread waits for the disk all the time
        write(log, 10 * k, 10 * k + 10)
        log.flush({})
    disk.free.set()
    log.wait_until_idle()
    assert "the disk is slow" in [report.text[:16] for report in log.take_reports()]
    log.close()
    assert sequences(tmp_path / "run.mcap") == (list(range(200)), [])
    assert log.lost == {}


def test_what_does_not_fit_is_counted_in_the_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    capacity = 50 * (len(DATA) + MESSAGE_BYTES)
    log = BackgroundLog(SegmentedLog(tmp_path / "run.mcap", {}, Chain("full")), capacity_bytes=capacity)
    disk = Disk(monkeypatch)
    log.flush({KEY: 1})  # of this alone nothing waits
    write(log, 0, 10)
    log.flush({KEY: 2})
    assert disk.asked.wait(PATIENCE_S)
    for k in range(1, 10):
        write(log, 10 * k, 10 * k + 10)
    disk.free.set()
    log.wait_until_idle()
    write(log, 100, 110)
    [lost] = [report for report in log.take_reports() if report.kind == "lost"][-1:]
    assert lost.text.startswith(f"the disk is too slow or full: {log.lost[KEY]} messages not logged so far")
    log.close({KEY: 2})
    kept, shortcomings = sequences(tmp_path / "run.mcap")
    assert len(kept) + log.lost[KEY] == 110
    assert kept[:50] == list(range(50))
    assert kept[-10:] == list(range(100, 110))
    assert shortcomings == [
        f"messages that the recorder never received: 2 of {KEY}",
        f"messages that the recorder could not write: {log.lost[KEY]} of {KEY}",
    ]


def test_a_second_close_has_no_effect(tmp_path: Path) -> None:
    with BackgroundLog(SegmentedLog(tmp_path / "run.mcap", {}, Chain("closed"))) as log:
        write(log, 0, 5)
        log.close()
    assert sequences(tmp_path / "run.mcap") == (list(range(5)), [])
