from pathlib import Path

import numpy as np
import pytest
from closed_form import MS, ClosedFormRun, paper_scenario
from passafe_dashboard.run_report import render_report, series_of
from passafe_protocol.codec import encode
from passafe_protocol.messages import FilterStatus
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> RunLog:
    """Log of 0.5 s of the closed-form run."""
    path: Path = tmp_path_factory.mktemp("log") / "run.mcap"
    metadata = run_metadata(
        scenario_json=paper_scenario().model_dump_json(), versions={"passafe": "1"}, driver="lockstep"
    )
    with LogWriter(path, metadata) as writer:
        for header, body, _ in ClosedFormRun().until(500 * MS):
            topic = TOPIC_OF_BODY[type(body)]
            key = topic.key(header.source)
            writer.write(key, encode(header, body), sequence=header.sequence, wall_ns=header.wall_ns)
    return RunLog.read(path)


def test_series_hold_the_measurements_of_the_plant(log: RunLog) -> None:
    series = series_of(log, CoreEvaluator(log.identity.scenario))
    assert series.times_s == pytest.approx(np.arange(500) * 1e-3)
    assert series.h[0] == pytest.approx(series.x[0] ** 2 + series.x[1] ** 2 - 1.0)
    # y = x₂ = 0 and V = ‖x‖² give h_u = yᵀu − 2x₁ᵀx₂ − 2x₂ᵀ(−σx₂ + u) = 0.
    assert series.power_margin_w == pytest.approx(np.zeros(500))
    assert [obstacle.name for obstacle in series.barriers] == ["disk"]
    assert {span.status for span in series.statuses} == {FilterStatus.PASSED, FilterStatus.MODIFIED}


def test_the_report_of_a_log_shows_its_verdict_and_configuration(log: RunLog) -> None:
    mathematics = CoreEvaluator(log.identity.scenario)
    page = render_report(log, mathematics, Verdict.of(log, mathematics))
    assert "notomista-cai-2020" in page
    assert "playout_s" in page
    assert "Trajectory" in page
