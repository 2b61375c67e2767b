"""Links of a scenario: ranges, what goes together, planned changes, recorded traces."""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any, get_args

import pytest
from passafe_protocol.link_change import LinkChange
from passafe_protocol.link_settings import DISTRIBUTIONS, RANGES, LinkSettings
from passafe_protocol.networks import NETWORKS
from passafe_protocol.topics import LINKS
from passafe_services.scenarios.errors import LinkTraceError, ScenarioError
from passafe_services.scenarios.link_schema import LinkName, NetworkName, ScenarioLink
from passafe_services.scenarios.link_trace import read_trace
from passafe_services.scenarios.links import link_changes, link_settings
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario

LINK = "plant-to-filter"


def load(**values: object) -> Scenario:
    return load_scenario("notomista-cai-2020", values)


def test_schema_has_every_link_and_every_setting() -> None:
    assert set(get_args(LinkName)) == set(LINKS)
    assert set(ScenarioLink.model_fields) - {"trace"} == {f.name for f in fields(LinkSettings)} - {
        "trace_s",
        "delay_trace_s",
    }
    assert ScenarioLink().settings() == LinkSettings()


@pytest.mark.parametrize("field", RANGES)
def test_the_schema_has_the_ranges_of_the_link(field: str) -> None:
    least, largest = RANGES[field]
    for limit in (least, largest):
        assert getattr(load(**{f"links.{LINK}": {field: limit}}).links[LINK], field) == limit
    for beyond in (least - 1e-6, largest * 1.001, float("nan")):
        with pytest.raises(ScenarioError) as caught:
            load(**{f"links.{LINK}": {field: beyond}})
        assert caught.value.field == f"links.{LINK}.{field}"


def test_all_settings_reach_the_link() -> None:
    given: dict[str, Any] = {
        "delay_s": 0.1,
        "distribution": "histogram",
        "quantiles_s": [0.0, 0.1, 0.5],
        "correlation": 0.5,
        "reorder": False,
        "loss": 0.1,
        "burst_enter": 0.01,
        "burst_leave": 0.2,
        "burst_loss_good": 0.001,
        "burst_loss_bad": 0.9,
        "duplicate": 0.02,
        "corrupt": 0.03,
        "rate_hz": 100.0,
        "queue": 5,
        "outages_s": [[1.0, 2.0], [3.0, 4.5]],
        "seed": 9,
    }
    settings = link_settings(load(**{f"links.{LINK}": given}))[LINK]

    for field, value in given.items():
        expected = tuple(map(tuple, value)) if field == "outages_s" else value
        got = getattr(settings, field)
        assert got == (tuple(expected) if isinstance(expected, list) else expected), field


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"distribution": "gamma"}, "distribution"),
        ({"distribution": "histogram"}, "quantiles_s"),
        ({"quantiles_s": [0.1, 0.2]}, "quantiles_s"),
        ({"outages_s": [[2.0, 1.0]]}, "outages_s"),
        ({"trace": "trace.csv", "rate_hz": 10.0}, "rate_hz"),
        ({"queue": 0}, "queue"),
        ({"delay": 0.1}, "delay"),
    ],
)
def test_what_a_link_cannot_be_is_refused_by_name(given: dict[str, Any], named: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(**{f"links.{LINK}": given})

    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_every_distribution_can_be_configured() -> None:
    for name in DISTRIBUTIONS:
        table = [0.0, 1.0] if name == "histogram" else []
        assert load(**{f"links.{LINK}": {"distribution": name, "quantiles_s": table}}).links[LINK].distribution == name


CHANGES = [
    {"at_s": 2.0, "link": LINK, "settings": {"loss": 0.5}},
    {"at_s": 1.0, "link": LINK, "settings": {"delay_s": 0.2}},
    {"at_s": 1.5, "link": "filter-to-plant", "settings": {"seed": 3}},
]


def test_a_planned_change_leaves_the_other_settings_as_they_are() -> None:
    scenario = load(**{f"links.{LINK}": {"jitter_s": 0.01}, "link_changes": CHANGES})

    assert link_changes(scenario) == (
        LinkChange(at_s=1.0, link=LINK, settings=LinkSettings(jitter_s=0.01, delay_s=0.2)),
        LinkChange(at_s=1.5, link="filter-to-plant", settings=LinkSettings(seed=3)),
        LinkChange(at_s=2.0, link=LINK, settings=LinkSettings(jitter_s=0.01, delay_s=0.2, loss=0.5)),
    )


def test_planned_changes_survive_being_written_down() -> None:
    scenario = load(link_changes=CHANGES)
    again = Scenario.model_validate_json(scenario.model_dump_json())

    assert json.loads(scenario.model_dump_json())["link_changes"] == CHANGES
    assert again == scenario
    assert link_changes(again) == link_changes(scenario)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"at_s": -1.0, "link": LINK, "settings": {}}, "at_s"),
        ({"at_s": 1.0, "link": "filter-to-moon", "settings": {}}, "link"),
        ({"at_s": 1.0, "link": LINK, "settings": {"loss": 2.0}}, "loss"),
        ({"at_s": 1.0, "link": LINK, "settings": {"distribution": "histogram"}}, "quantiles_s"),
        ({"at_s": 1.0, "link": LINK}, "settings"),
    ],
)
def test_a_change_that_cannot_be_is_refused_by_name(change: dict[str, Any], named: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load(link_changes=[change])

    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "trace_s"),
    [
        ("0\n1\n1\n5\n", (0.0, 0.001, 0.001, 0.005)),
        ("time_s\n0.5\n2\n", (0.5, 2.0)),
        ("time_ms\n500\n\n2000\n", (0.5, 2.0)),
        ("1", (0.001,)),
    ],
)
def test_a_trace_is_read_in_the_unit_it_names_or_in_ms(tmp_path: Path, text: str, trace_s: tuple[float, ...]) -> None:
    path = tmp_path / "trace.csv"
    path.write_text(text)

    assert read_trace(path).trace_s == pytest.approx(trace_s)
    assert link_settings(load(**{f"links.{LINK}": {"trace": str(path)}}))[LINK].trace_s == read_trace(path).trace_s


@pytest.mark.parametrize(
    ("content", "named"),
    [
        (b"", "no times"),
        (b"time_s\n", "no times"),
        (b"time_us\n1\n", "time_us"),
        (b"1,2\n", "sent_s,delay_s"),
        (b"sent_s,delay_us\n", "sent_s,delay_s"),
        (b"sent_s,delay_s\n", "no times"),
        (b"sent_s,delay_s\n0,0.1\n1,x\n", "line 3: 'x'"),
        (b"sent_s,delay_s\n0,0.1\n1,nan\n", "line 3: 'nan'"),
        (b"sent_s,delay_s\n0,0.1\n1\n", "line 3: 1 columns"),
        (b"sent_s,delay_s\n1,0.1\n0,0.1\n", "line 3: 0 after 1 s"),
        (b"sent_s,delay_s\n0,0.1\n1,11\n", "0 to 10 s"),
        (b"1\n1,2\n", "line 2: 2 columns"),
        (b"5\n1\n", "non-decreasing"),
        (b"0\n", "above 0"),
        (b"nan\n", "line 1: 'nan'"),
        (b"\xff\xfe\x00", "readable CSV"),
    ],
)
def test_a_file_that_is_no_trace_is_refused_in_one_line(tmp_path: Path, content: bytes, named: str) -> None:
    path = tmp_path / "trace.csv"
    path.write_bytes(content)

    with pytest.raises(LinkTraceError) as caught:
        load(**{f"links.{LINK}": {"trace": str(path)}})

    assert caught.value.path == path
    assert named in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_trace_of_delays_begins_at_its_first_probe(tmp_path: Path) -> None:
    path = tmp_path / "trace.csv"
    path.write_text("sent_ms,delay_ms\n1000,20\n1100,lost\n1200,30\n")

    settings = link_settings(load(**{f"links.{LINK}": {"trace": str(path)}}))[LINK]

    expected = [(0.0, 0.02), (0.1, float("inf")), (0.2, 0.03)]
    assert [*map(list, settings.delay_trace_s)] == [pytest.approx(pair) for pair in expected]


def test_a_network_beside_a_trace_of_delays_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "trace.csv"
    path.write_text("sent_s,delay_s\n0,0.1\n1,0.2\n")

    with pytest.raises(LinkTraceError, match="none if there is a trace"):
        load(**{f"links.{LINK}": {"trace": str(path), "network": "lte-driving"}})


def test_every_network_is_a_setting_of_links() -> None:
    assert get_args(NetworkName) == ("", *NETWORKS)
    for name in NETWORKS:
        assert link_settings(load(**{f"links.{LINK}": {"network": name}}))[LINK].network == name


def test_a_trace_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LinkTraceError, match="nowhere"):
        load(link_changes=[{"at_s": 1, "link": LINK, "settings": {"trace": str(tmp_path / "nowhere.csv")}}])
