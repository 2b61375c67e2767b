"""The HTML report of a log."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from closed_form_log import circle_messages, record_of, write_log
from closed_form_series import verdict
from passafe_dashboard.number_text import number
from passafe_dashboard.reports.report_run import ReportRun
from passafe_dashboard.reports.run_page import inline_script, report_page
from passafe_dashboard.run_record.collector import RunCollector
from passafe_dashboard.run_report import overlay_report, render_report, report_run, write_report
from passafe_services.tools.export.errors import ExportError
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

CONFIGURATION = {"name": "circle", "title": "a <b>circle</b> & </script>"}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_log(tmp_path_factory.mktemp("log") / "run.mcap", circle_messages(500))


@pytest.fixture(scope="module")
def record(log: Path) -> RunCollector:
    return record_of(log)


def run(record: RunCollector, said: dict[str, Any], **changes: Any) -> ReportRun:  # noqa: ANN401 - any field
    fields = {"label": "run", "configuration": CONFIGURATION, "versions": {"passafe": "1"}} | changes
    return ReportRun(record=record, verdict=said, **fields)


@pytest.fixture(scope="module")
def page(record: RunCollector) -> str:
    return report_page([run(record, verdict())], title="circle")


def markup(page: str) -> str:
    """Return the page without scripts and styles."""
    return re.sub(r"<(script|style)[ >].*?</\1>", "", page, flags=re.DOTALL)


def cells(page: str, head: str) -> list[str]:
    """Texts of the table row that begins with ``head``, without elements in them."""
    row = re.search(rf"<tr><th scope=\"row\">{re.escape(head)}</th>(.*?)</tr>", markup(page), re.DOTALL)
    assert row is not None, head
    return [re.sub(r"<[^>]*>", "", cell) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row.group(1))]


def data(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    return json.loads(found.group(1))


def test_properties_have_outcome_worst_value_and_time(page: str) -> None:
    assert cells(page, "safe")[:4] == ["holds", "yes", "0.44", "1.571 s"]
    assert cells(page, "passive") == ["violated", "yes", "−0.2", "3.142 s", "h_u ≥ −0.05"]
    assert cells(page, "certified")[:4] == ["unknown", "no", "unknown", "–"]
    assert "A required property is violated" in page


def test_every_violation_is_a_click_away(page: str) -> None:
    jumps = re.findall(r'data-jump="([^"]*)">(.*?)</button>', markup(page), re.DOTALL)
    first = re.sub(r"<[^>]*>", "", jumps[0][1])
    assert (jumps[0][0], first) == ("3.142", "passive violated, worst −0.2 3.142 s")
    assert any("fail-safe" in text for _, text in jumps)


def test_metrics_and_timing_are_those_of_the_verdict(page: str) -> None:
    assert cells(page, "lowest h, between samples too") == ["0.44"]
    assert cells(page, "final x") == ["(−1.5, 0.25, 0, −0.0001)"]
    assert cells(page, "filter ticks") == ["10000"]
    assert cells(page, "messages missing in the log") == ["tick 2"]
    assert cells(page, "filter step: state in, input out") == ["µs", "21.5", "80.2", "120", "400"]
    assert cells(page, "lateness of filter") == ["µs", "70", "300", "900", "1.5·10³"]
    assert "operator to plant" not in page


def test_report_is_self_contained(page: str) -> None:
    assert "default-src &#39;none&#39;" in page
    assert "unsafe" not in re.findall(r'Content-Security-Policy" content="([^"]*)"', page)[0]
    assert re.findall(r"\b(?:src|href|action|data)=\"(?!data:)[^\"]*\"", markup(page)) == []
    assert not re.search(r"@import|url\(", "".join(re.findall(r"<style>(.*?)</style>", page, re.DOTALL)))
    assert " style=" not in markup(page)  # the policy refuses styles of elements
    assert len(page) < 300_000


def test_text_of_a_log_is_escaped(page: str) -> None:
    assert "a &lt;b&gt;circle&lt;/b&gt; &amp; &lt;/script&gt;" in page
    assert "no input: &lt;b&gt;fail-safe&lt;/b&gt;" in page
    assert page.count("</script>") == page.count("<script") == 2


def test_text_of_a_script_cannot_end_it() -> None:
    assert inline_script("a </script> <!-- b") == "a <\\/script> <\\!-- b"


def test_unknown_metrics_are_called_unknown(record: RunCollector) -> None:
    unknown = verdict(h_min=None, timing=None, status_counts=None, gaps=None, final_x=None, verdict="unproven")
    unknown["words"] = "unproven: safe is unknown"
    page = report_page([run(record, unknown)], title="circle")
    assert '<p class="words">safe is unknown</p>' in page
    assert cells(page, "lowest h, between samples too") == ["unknown"]
    assert cells(page, "final x") == ["unknown"]
    assert cells(page, "messages missing in the log") == ["unknown"]
    assert cells(page, "commands of the operator") == ["unknown"]
    assert "This log holds no timing." in page
    assert "Not proven" in page


def test_use_of_the_commands_is_a_fact_in_words(record: RunCollector) -> None:
    used = verdict(commands={"shares": {"counts": 0.25, "delayed": 0.75}, "text": "counted 25 %, too old 75 %"})
    page = report_page([run(record, used)], title="circle")
    assert cells(page, "commands of the operator") == ["counted 25 %, too old 75 %"]


def test_violation_that_the_mode_allows_is_no_plain_success(record: RunCollector) -> None:
    properties = verdict()["properties"]
    properties["passive"]["required"] = False
    page = report_page([run(record, verdict(mode="off", verdict="holds", properties=properties))], title="circle")
    assert 'badge limited">Every required property holds; violated, but not required: passive' in page
    assert "passive violated (not required), worst −0.2" in page


def test_links_are_accounted_for(record: RunCollector) -> None:
    dropped = {"loss": 979, "queue": 0, "outage": 0}
    account = {
        "link": "plant-to-filter", "sent": 10006, "lost_on_bus": 1, "duplicated": 407, "delivered": 8793,
        "dropped": dropped, "in_flight": 234, "corrupted": 0, "differences": {},
    }  # fmt: skip
    wrong = account | {"link": "filter-to-plant", "differences": {"dropped": 3}}
    page = report_page([run(record, verdict(links=[account, wrong]))], title="circle")
    assert cells(page, "plant-to-filter") == ["10006", "1", "407", "8793", "979", "0", "0", "234", "0", "exact"]
    assert cells(page, "filter-to-plant")[-1] == "dropped: 3"


def test_a_report_of_a_log_shows_verdict_and_configuration(log: Path, record: RunCollector) -> None:
    read = RunLog.read(log)
    judged = Verdict.of(read, CoreEvaluator(read.identity.scenario))
    page = render_report(record, judged, read.identity)
    assert "<h1>The paper&#39;s robot and disk</h1>" in page
    assert "playout_s" in page
    assert [chart["key"] for chart in data(page)["charts"]][:3] == ["status", "h", "psi"]
    other = report_run(record, judged, read.identity, label="later", offset_s=0.25)
    both = overlay_report([report_run(record, judged, read.identity), other], title="two", notes=["Same <operator>."])
    assert [one["label"] for one in data(both)["runs"]] == ["run", "later"]
    assert data(both)["runs"][1]["offset_s"] == 0.25
    assert "<p>Same &lt;operator&gt;.</p>" in both


def test_charts_are_described_in_words(page: str) -> None:
    said = data(page)["descriptions"]
    assert said["h"].startswith("Barriers h over plant time. disk from 1.76 to 2.24 m²")
    assert "Obstacles: disk." in page


def test_a_report_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    folder = tmp_path / "report.html"
    folder.mkdir()
    (folder / "kept").touch()
    with pytest.raises(ExportError, match="cannot be written"):
        write_report(folder, "text")
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]
    write_report(tmp_path / "new.html", "text")
    assert (tmp_path / "new.html").read_text("utf-8") == "text"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.1 + 0.2, "0.3"), (-2.0, "−2"), (1234567.0, "1.235·10⁶"), (-1e-7, "−1·10⁻⁷"), (None, "unknown")],
)
def test_numbers_are_short_and_signed(value: object, text: str) -> None:
    assert number(value) == text
