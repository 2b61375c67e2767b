"""Epochs of restarted processes."""

import json
import sys
from pathlib import Path

import pytest
from passafe_services.loop.process_spec import ProcessSpec, RestartPolicy
from passafe_services.loop.session_epochs import SessionEpochs
from passafe_services.loop.supervisor import supervise

HOUR_NS = 3_600_000_000_000
FAILING = """import json, sys, time
from pathlib import Path
from passafe_services.loop.readiness import announce_ready
print(json.dumps(sys.argv[2:]), flush=True)
announce_ready("filter")
while not Path(sys.argv[1]).exists():
    time.sleep(0.005)
sys.exit(3)"""
"""Dies once all are ready: a process that dies before ends the run."""


def test_epoch_is_the_wall_clock_while_it_advances() -> None:
    epochs = SessionEpochs(iter((100, 250, 251)).__next__)

    assert [epochs.next() for _ in range(3)] == [100, 250, 251]


def test_clock_that_is_set_back_makes_no_epoch_smaller() -> None:
    now = [5 * HOUR_NS]
    epochs = SessionEpochs(lambda: now[0])
    before = epochs.next()
    now[0] = 4 * HOUR_NS
    again = [epochs.next() for _ in range(3)]
    now[0] = 6 * HOUR_NS

    assert again == [before + 1, before + 2, before + 3]
    assert epochs.next() == 6 * HOUR_NS


def test_clock_that_stands_gives_no_epoch_twice() -> None:
    epochs = SessionEpochs(lambda: 7)

    assert len({epochs.next() for _ in range(10)}) == 10


@pytest.mark.live
def test_restarted_process_has_a_larger_epoch_than_before(tmp_path: Path) -> None:
    """The clock goes back by an hour after the first start; the process dies five times, then the run ends."""
    clock = iter([5 * HOUR_NS, *(4 * HOUR_NS + k for k in range(10))])
    lines: list[str] = []
    all_ready = tmp_path / "ready"
    argv = (sys.executable, "-c", FAILING, str(all_ready), "--own", "1")
    spec = ProcessSpec(name="filter", argv=argv, epoch_option="--epoch", restarts=RestartPolicy())
    supervise([spec], on_ready=all_ready.touch, emit=lines.append, epochs=SessionEpochs(clock.__next__))
    reported = [json.loads(line.partition(" | ")[2]) for line in lines if " | [" in line]

    assert [words[:3] for words in reported] == [["--own", "1", "--epoch"]] * 6
    assert [int(words[3]) - 5 * HOUR_NS for words in reported] == [0, 1, 2, 3, 4, 5]
