import re
from dataclasses import replace

import numpy as np
import pytest
from barrier_examples import disk
from closed_form_series import run_series, verdict
from passafe_dashboard.number_text import number
from passafe_dashboard.pictures.run_picture import run_picture
from passafe_dashboard.reports.run_page import inline_script, report_page
from passafe_dashboard.run_description import descriptions

CONFIGURATION = {"name": "circle", "title": "a <b>circle</b> & </script>"}
VERSIONS = {"passafe": "0.1.0"}


@pytest.fixture(scope="module")
def page() -> str:
    return report_page(verdict(), run_series(), configuration=CONFIGURATION, versions=VERSIONS)


def markup(page: str) -> str:
    """Return the page without scripts and styles."""
    return re.sub(r"<(script|style)>.*?</\1>", "", page, flags=re.DOTALL)


def cells(page: str, head: str) -> list[str]:
    """Texts of the table row that begins with ``head``."""
    row = re.search(rf"<tr><th scope=\"row\">{re.escape(head)}</th>(.*?)</tr>", markup(page), re.DOTALL)
    assert row is not None, head
    return re.findall(r"<td[^>]*>(.*?)</td>", row.group(1))


def test_the_report_has_the_paper_s_plots(page: str) -> None:
    for heading in ("Trajectory", "Barriers", "Power margin", "Filter status"):
        assert f"<h2>{heading}</h2>" in page
    assert markup(page).count("data-root-id") == 4
    assert "h of disk, measured" in page
    assert "limit: h = 0" in page


def test_properties_have_outcome_worst_value_and_time(page: str) -> None:
    assert cells(page, "safe")[:4] == ["holds", "yes", "0.44", "1.571 s"]
    assert cells(page, "passive") == ["violated", "yes", "−0.2", "3.142 s", "h_u ≥ −0.05"]
    assert cells(page, "certified")[:4] == ["unknown", "no", "unknown", "–"]
    assert "A required property is violated" in page


def test_lowest_of_many_barriers_are_shown() -> None:
    series = run_series(100)
    disks = tuple(disk(f"disk {n}") for n in range(10))
    many = replace(series, barriers=disks, h=np.vstack([series.h + 9 - n for n in range(10)]))
    assert many.lowest_barriers == tuple(range(2, 10))
    words = descriptions(many)["h"]
    assert "disk 2 lowest sample" in words
    assert "disk 1 lowest sample" not in words
    assert f"2 others not shown, none below {series.h.min() + 8:.4g}" in words


def test_two_robots_have_a_path_each_and_joints_have_none() -> None:
    series = run_series(100)
    assert descriptions(replace(series, points=2))["plane"].count("Path of the robot") == 2
    joints = replace(series, points=0)
    page = report_page(verdict(), joints, configuration=CONFIGURATION, versions=VERSIONS)
    assert "<h2>Trajectory</h2>" not in page
    assert "<h2>Power margin</h2>" in page
    assert "position p₁" not in run_picture(joints, title="joints")


def test_metrics_and_timing_are_those_of_the_verdict(page: str) -> None:
    assert cells(page, "lowest h") == ["0.44"]
    assert cells(page, "final x") == ["(−1.5, 0.25, 0, −0.0001)"]
    assert cells(page, "filter ticks") == ["10000"]
    assert cells(page, "messages missing in the log") == ["tick 2"]
    assert cells(page, "filter step: state in, input out") == ["µs", "21.5", "80.2", "120", "400"]
    assert cells(page, "lateness of filter") == ["µs", "70", "300", "900", "1.5e+03"]
    assert "operator to plant" not in page


def test_report_is_self_contained(page: str) -> None:
    assert "default-src 'none'" in page
    assert re.findall(r"\b(?:src|href|action|data)=\"(?!data:)[^\"]*\"", markup(page)) == []
    assert not re.search(r"@import|url\(", "".join(re.findall(r"<style>(.*?)</style>", page, re.DOTALL)))
    assert len(page) < 4_000_000


def test_text_of_a_log_is_escaped(page: str) -> None:
    assert "a &lt;b&gt;circle&lt;/b&gt; &amp; &lt;/script&gt;" in page
    assert page.count("</script>") == page.count("<script>") == 2


def test_unknown_metrics_are_called_unknown() -> None:
    unknown = verdict(h_min=None, timing=None, status_counts=None, gaps=None, final_x=None, verdict="unproven")
    unknown["words"] = "unproven: safe is unknown"
    page = report_page(unknown, run_series(100), configuration={}, versions={})
    assert "<p>unproven: safe is unknown</p>" in page
    assert cells(page, "lowest h") == ["unknown"]
    assert cells(page, "final x") == ["unknown"]
    assert cells(page, "messages missing in the log") == ["unknown"]
    assert cells(page, "commands of the operator") == ["unknown"]
    assert "This log holds no timing." in page
    assert "Not proven" in page


def test_use_of_the_commands_is_a_fact_in_words() -> None:
    used = verdict(commands={"shares": {"counts": 0.25, "delayed": 0.75}, "text": "counted 25 %, too old 75 %"})
    page = report_page(used, run_series(100), configuration={}, versions={})

    assert cells(page, "commands of the operator") == ["counted 25 %, too old 75 %"]


def test_violation_that_the_mode_allows_is_named() -> None:
    properties = verdict()["properties"]
    properties["passive"]["required"] = False
    page = report_page(
        verdict(mode="off", verdict="holds", properties=properties),
        run_series(100),
        configuration={},
        versions={},
    )
    assert 'not required in this mode: <strong class="bad">passive</strong>' in page


def test_a_run_without_barriers_and_ticks_has_its_plots() -> None:
    series = run_series(100)
    bare = replace(series, h=series.h[:0], barriers=(), statuses=())
    page = report_page(verdict(), bare, configuration={}, versions={})
    assert markup(page).count("data-root-id") == 2
    assert "Obstacles: none." in page


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.1 + 0.2, "0.3"), (-2.0, "−2"), (1234567.0, "1.235e+06"), (-1e-7, "−1e−07"), (None, "unknown")],
)
def test_numbers_are_short_and_signed(value: object, text: str) -> None:
    assert number(value) == text


def test_a_script_cannot_end_its_element() -> None:
    text = inline_script('a = "</script><!--";')
    assert "</script" not in text
    assert "<!--" not in text


def test_account_of_every_link_is_shown() -> None:
    account = {
        "link": "plant-to-filter",
        "sent": 100,
        "lost_on_bus": 1,
        "duplicated": 4,
        "delivered": 90,
        "dropped": {"loss": 10, "queue": 2, "outage": 0},
        "in_flight": 1,
        "corrupted": 3,
        "differences": {},
    }
    wrong = account | {"link": "filter-to-plant", "differences": {"balance": 2}}
    page = report_page(
        verdict() | {"links": [account, wrong]}, run_series(), configuration=CONFIGURATION, versions=VERSIONS
    )

    assert cells(page, "plant-to-filter") == ["100", "1", "4", "90", "10", "2", "0", "1", "3", "exact"]
    assert cells(page, "filter-to-plant")[-1] == "balance: 2"
