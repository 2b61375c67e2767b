"""Runs set side by side."""

import json
from pathlib import Path

import numpy as np
import pytest
from passafe_services.cli.app import app
from passafe_services.tools.compare.alignment import origin_s
from passafe_services.tools.compare.comparison import apart
from passafe_services.tools.compare.errors import AlignmentError
from passafe_services.tools.experiment.tracking import Tracking
from passafe_services.tools.review.run_log import RunLog
from typer.testing import CliRunner

GOLDEN = Path(__file__).parents[1] / "golden"


@pytest.fixture(scope="module")
def log() -> RunLog:
    return RunLog.read(GOLDEN / "bad-links.mcap")


def test_robots_apart_in_closed_form() -> None:
    t_s = np.linspace(0.0, 1.0, 11)
    first = Tracking(t_s=t_s, position=np.array([t_s, 0 * t_s]))
    other = Tracking(t_s=t_s, position=np.array([t_s, 3 * t_s]))
    found = apart(first, other)
    assert found is not None
    assert found.largest == found.final == pytest.approx(3.0)
    assert found.largest_at_s == pytest.approx(1.0)
    assert found.rms == pytest.approx(3.0 * np.sqrt(np.mean(t_s**2)))


def test_other_times_are_interpolated() -> None:
    first = Tracking(t_s=np.array([0.0, 0.5, 1.0]), position=np.array([[0.0, 0.5, 1.0]]))
    other = Tracking(t_s=np.array([0.25, 1.25]), position=np.array([[0.25, 1.25]]))
    found = apart(first, other)
    assert found is not None
    assert found.largest == pytest.approx(0.0)


def test_runs_without_common_times_are_not_apart() -> None:
    first = Tracking(t_s=np.array([0.0, 1.0]), position=np.zeros((1, 2)))
    assert apart(first, Tracking(t_s=np.array([2.0, 3.0]), position=np.zeros((1, 2)))) is None
    assert apart(first, Tracking(t_s=np.zeros(0), position=np.zeros((0, 0)))) is None


def test_alignment_by_event(log: RunLog) -> None:
    assert origin_s(log, "start") == 0.0
    assert origin_s(log, "first-input") > 0.0
    assert origin_s(log, "event:passed") >= 0.0
    assert origin_s(RunLog.read(GOLDEN / "live.mcap"), "event:text=started") >= 0.0


@pytest.mark.parametrize("align", ["begin", "event:nothing", "event:stop", "event:fail-safe", "event:break"])
def test_alignment_that_is_not_possible_is_refused(align: str) -> None:
    with pytest.raises(AlignmentError, match="allowed start, first-input, or event:KIND"):
        origin_s(RunLog.read(GOLDEN / "reference.mcap"), align)


def test_json_of_two_logs() -> None:
    logs = [str(GOLDEN / "reference.mcap"), str(GOLDEN / "reference-off.mcap")]
    data = json.loads(CliRunner().invoke(app, ["compare", *logs, "--json"]).stdout)
    first, second = data["runs"]
    assert set(first["differences"].values()) == {0.0}
    assert second["differences"]["h_min"] == second["metrics"]["h_min"] - first["metrics"]["h_min"]
    assert second["apart"]["largest"] > 0


def test_one_log_is_no_comparison() -> None:
    result = CliRunner().invoke(app, ["compare", str(GOLDEN / "reference.mcap")])
    assert "LOG: got 1 log, allowed two or more" in str(result.exception)
