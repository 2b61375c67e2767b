"""The page of an experiment, from results that are made up and known."""

import re
import xml.etree.ElementTree as ET
from base64 import b64decode
from typing import Any

import pytest
from passafe_dashboard.pictures.line_chart import LineChart, line_chart_picture
from passafe_dashboard.reports.experiment_charts import boundary_charts, charts_of
from passafe_dashboard.reports.experiment_page import KeptLine, experiment_page
from passafe_services.tools.experiment.cells import Run
from passafe_services.tools.experiment.live_agreement import Agreement
from passafe_services.tools.experiment.load import experiment_from
from passafe_services.tools.experiment.metrics import Metrics
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.summary import ExperimentSummary

DELAY = {"name": "delay_s", "key": "links.plant-to-filter.delay_s", "values": [0.0, 0.1, 0.2]}
LOSS = {"name": "loss", "key": "links.plant-to-filter.loss", "values": [0.0, 0.5]}
HOLD = {"name": "hold_s", "kind": "bisect", "key": "plant.hold_s", "low": 0.0, "high": 1.0, "steps": 2}
LOW = {"name": "r", "kind": "uniform", "key": "plant.x0.0", "low": 2.0, "high": 3.0}


def metrics(h_min: float) -> Metrics:
    numbers = {name: 0 for name, field in Metrics.model_fields.items() if field.annotation in {int, float}}
    none = dict.fromkeys(Metrics.model_fields)
    made: dict[str, Any] = {"h_min": h_min, "tank_min_j": 1.0, "status_counts": {}, "properties": {}}
    return Metrics.model_validate(none | numbers | made | {"verdict": "holds" if h_min >= 0 else "fails"})


def h_of(run: Run) -> float:
    """Falls with delay, below zero where the filter is off; with a hold longer than the delay leaves time for."""
    delay_s = run.values.get("delay_s", 0.0)
    assert isinstance(delay_s, float)
    h = (0.5 if run.variant == "both" else -0.5) - delay_s
    return h if run.probe is None or run.probe <= 0.75 - 2 * delay_s else -1.0


def finished(*axes: dict[str, Any], count: int = 2) -> tuple[Plan, ExperimentSummary]:
    content = {"schema_version": 2, "name": "made-up", "title": "Made <up>", "scenario": "notomista-cai-2020"}
    content |= {"variants": {"off": {}, "both": {}}, "axes": axes, "seeds": {"count": count}}
    plan = Plan(experiment_from(content, "made-up"))
    waiting = list(plan.first())
    while waiting:
        run = waiting.pop()
        waiting += plan.after(RunResult(run=run, metrics=metrics(h_of(run) + 0.01 * run.seed), wall_s=0.1))
    return plan, ExperimentSummary.of(plan)


def test_metric_is_drawn_over_the_longest_axis() -> None:
    charts = charts_of(*finished(DELAY, LOSS))

    assert [(chart.x_label, chart.y_label) for chart in charts] == [
        ("delay_s, where loss = 0", "h_min"),
        ("delay_s, where loss = 0.5", "h_min"),
        ("delay_s, where loss = 0", "tank_min_j"),
        ("delay_s, where loss = 0.5", "tank_min_j"),
    ]
    off, both = charts[0].curves
    assert (off.label, both.label) == ("off", "both")
    assert both.x == (0.0, 0.1, 0.2)
    assert both.low == pytest.approx((0.5, 0.4, 0.3))
    assert both.y == pytest.approx((0.505, 0.405, 0.305))
    assert both.high == pytest.approx((0.51, 0.41, 0.31))
    assert charts[0].limit == 0.0


def test_boundaries_are_drawn_up_to_the_largest_holding_value() -> None:
    plan, summary = finished(DELAY, HOLD)
    safe, solvent = boundary_charts(plan.experiment, summary)
    off, both = safe.curves

    assert off.y == (0.0, 0.0, 0.0)  # fails already at the lowest value
    assert both.y == pytest.approx((0.75, 0.5, 0.3125), abs=0.0626)
    assert all(up_to <= 0.75 - 2 * delay_s for up_to, delay_s in zip(both.y, both.x, strict=True))
    assert solvent.curves[0].y == (1.0, 1.0, 1.0)
    assert solvent.curves[0].open_at == (0, 1, 2)
    assert both.open_at == both.doubtful_at == ()


def test_boundary_that_is_not_monotone_is_marked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "h_of", lambda run: -1.0 if 0.3 < (run.probe or 0.0) < 0.6 else 1.0)
    plan, summary = finished(DELAY, HOLD, count=1)
    safe, _ = boundary_charts(plan.experiment, summary)

    assert safe.curves[0].doubtful_at == (0, 1, 2)
    assert "not monotone" in experiment_page(plan, summary, [])


def test_random_axis_gives_a_scatter_chart_with_a_point_per_run() -> None:
    charts = charts_of(*finished(LOW, count=7))

    assert [(chart.x_label, chart.y_label, chart.points) for chart in charts] == [
        ("r", "h_min", True),
        ("r", "tank_min_j", True),
    ]
    assert [len(curve.x) for curve in charts[0].curves] == [7, 7]
    assert charts[0].curves[0].x == charts[0].curves[1].x


def picture_of(charts: list[LineChart]) -> str:
    words = " ".join(chart.description for chart in charts)
    return line_chart_picture(charts, columns=1, title="Boundaries", description=words)


def test_the_picture_is_well_formed_and_says_what_it_shows() -> None:
    plan, summary = finished(DELAY, HOLD)
    charts = boundary_charts(plan.experiment, summary)
    root = ET.fromstring(picture_of(charts))  # noqa: S314 - our own output
    texts = ["".join(element.itertext()) for element in root.iter()]

    assert root.tag.endswith("svg")
    assert any("safe up to hold_s over delay_s: off from 0 at 0" in text for text in texts)
    assert "not tried beyond" in texts


def test_report_is_self_contained_and_lists_every_cell() -> None:
    plan, summary = finished(DELAY, LOSS)
    agreement = Agreement("both, delay_s = 0", "h_min", 0.4, 0.5, 0.5, 0.1, 0.01, "because")
    kept = KeptLine(cell="off, delay_s = 0.2", seed=3, file="logs/a.mcap", metric="h_min -0.7")
    page = experiment_page(plan, summary, [kept], [agreement])
    images = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', page)

    assert "<h1>Made &lt;up&gt;</h1>" in page
    assert "<script" not in page
    assert "http://" not in re.sub(r'src="data:[^"]+"', "", page)
    assert len(images) == 4
    assert all(ET.fromstring(b64decode(image)).tag.endswith("svg") for image in images)  # noqa: S314 - our own output
    assert page.count("<tr><td>off</td>") == page.count("<tr><td>both</td>") == 6
    assert '<td class="bad">100 % (34.2 to 100)</td>' in page
    assert 'href="logs/a.mcap"' in page
    assert '<td class="bad">0.1</td><td>0.01</td><td>because</td>' in page


def test_an_experiment_without_axes_has_a_table_and_no_chart() -> None:
    plan, summary = finished()

    assert charts_of(plan, summary) == []
    assert "<h2>Charts</h2>" not in experiment_page(plan, summary, [])
