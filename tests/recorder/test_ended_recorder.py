"""A child process that records, and is killed, stopped or limited in what it may write."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from logged_sequences import sequences
from mcap.records import Message as LoggedMessage
from passafe_protocol.codec import decode
from passafe_protocol.topics import EVENT
from passafe_services.log.log_reader import LogReader
from passafe_services.tools.recover import recover

MS = 1_000_000
CHILD = Path(__file__).with_name("writing_child.py")
PATIENCE_S = 30.0


@contextmanager
def writing_child(path: Path, limit_bytes: int = 0) -> Iterator[subprocess.Popen[str]]:
    child = subprocess.Popen(
        [sys.executable, str(CHILD), str(path), str(limit_bytes)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parents[2],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
    )
    try:
        yield child
    finally:
        child.kill()
        child.communicate(timeout=PATIENCE_S)


def test_kill_loses_at_most_300_ms(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with writing_child(path) as child:
        assert child.stdout is not None
        made_ns, growths, grown_ns, size = 0, 0, 0, 0
        for line in child.stdout:
            made_ns = int(line)
            if path.stat().st_size > size:
                size, growths, grown_ns = path.stat().st_size, growths + 1, made_ns
            if growths > 3 and made_ns - grown_ns > 110 * MS:  # shortly before the next flush: the worst moment
                break
        child.kill()
        rest = child.communicate(timeout=PATIENCE_S)[0]
        made_ns = max([made_ns, *map(int, rest.split()[:-1])])
    out = tmp_path / "out.mcap"
    recovery = recover(path, out)
    assert not recovery.was_finished
    last_ns = 0
    for entry in LogReader(out).records():
        last_ns = max(last_ns, getattr(entry, "log_time", 0))
    assert 50 * MS < made_ns - last_ns <= 300 * MS
    kept = sequences(out)
    assert kept == list(range(len(kept)))
    assert len(kept) > 1000


@pytest.mark.parametrize("signum", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_it_with_a_finished_file(tmp_path: Path, signum: int) -> None:
    path = tmp_path / "run.mcap"
    with writing_child(path) as child:
        assert child.stdout is not None
        first_ns = int(child.stdout.readline())
        child.send_signal(signum)
        rest, errors = child.communicate(timeout=PATIENCE_S)
    assert (child.returncode, errors) == (0, "")
    reader = LogReader(path)
    times = [record.log_time for record in reader.records() if hasattr(record, "log_time")]
    assert reader.finished
    assert times[-1] == max(first_ns, *map(int, rest.split()))


def test_a_limit_of_size_begins_another_file(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with writing_child(path, limit_bytes=300_000) as child:
        assert child.stdout is not None
        for _ in child.stdout:
            if (tmp_path / "run.3.mcap").exists():
                break
        child.terminate()
        _, errors = child.communicate(timeout=PATIENCE_S)
    assert child.returncode == 0
    assert f"error: {path}: cannot write the log: File too large; what was recorded before is in {path}" in errors
    assert path.stat().st_size <= 300_000
    reader = LogReader(path)
    entries = [entry for entry in reader.records() if isinstance(entry, LoggedMessage)]
    assert [entry.sequence for entry in entries] == list(range(len(entries)))
    assert len(entries) > 800
    assert (reader.finished, reader.shortcomings) == (True, [])
    for entry in entries[::100]:
        header, _ = decode(EVENT, entry.data)
        assert header.sequence == entry.sequence
