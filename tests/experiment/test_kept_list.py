"""The list of logs that were written: what it finds again, and what it does not."""

from pathlib import Path
from typing import Any

import pytest
from passafe_services.tools.experiment.cells import Run
from passafe_services.tools.experiment.kept_list import KeptList
from passafe_services.tools.experiment.kept_logs import KeptLog
from passafe_services.tools.experiment.run_result import RunResult


def result(seed: int = 0, wall_s: float = 0.5, probe: float | None = None) -> RunResult:
    run = Run(cell=1, variant="both", values={}, probe=probe, seed=seed)
    return RunResult(run=run, metrics=None, wall_s=wall_s)


@pytest.fixture
def kept(tmp_path: Path) -> KeptLog:
    path = tmp_path / "logs" / "cell-1-seed-0.mcap"
    path.parent.mkdir()
    path.touch()
    log = KeptLog(result(), path, ("h_min",))
    KeptList(tmp_path).add([log])
    return log


def test_log_is_found_again(kept: KeptLog) -> None:
    assert KeptList(kept.path.parents[1]).find(result()) == kept


@pytest.mark.parametrize("other", [{"seed": 1}, {"wall_s": 0.6}, {"probe": 0.5}])
def test_log_of_another_run_is_not_taken_for_it(other: dict[str, Any], kept: KeptLog) -> None:
    assert KeptList(kept.path.parents[1]).find(result(**other)) is None


def test_log_that_is_gone_is_written_again(kept: KeptLog) -> None:
    kept.path.unlink()

    assert KeptList(kept.path.parents[1]).find(result()) is None


def test_line_that_was_cut_off_is_no_log(kept: KeptLog) -> None:
    known = KeptList(kept.path.parents[1])
    known.path.write_text(known.path.read_text(encoding="utf-8")[:-10], encoding="utf-8")

    assert KeptList(kept.path.parents[1]).find(result()) is None


def test_line_after_one_that_was_cut_off_is_found(kept: KeptLog) -> None:
    known = KeptList(kept.path.parents[1])
    known.path.write_text('{"key": [1, nu', encoding="utf-8")
    KeptList(kept.path.parents[1]).add([kept])

    assert KeptList(kept.path.parents[1]).find(result()) == kept


def test_newest_log_of_a_run_counts(kept: KeptLog) -> None:
    other = kept.path.with_name("other.mcap")
    other.touch()
    newer = KeptLog(result(), other, ())
    KeptList(kept.path.parents[1]).add([newer])

    assert KeptList(kept.path.parents[1]).find(result()) == newer
