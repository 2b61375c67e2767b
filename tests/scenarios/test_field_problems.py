"""Every problem of a file is reported, in words, with the name that was most likely meant."""

import tomllib
from pathlib import Path

import pytest
from passafe_services.loop.errors import LinkNameError
from passafe_services.loop.inlet import require_links
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.errors import ScenarioError, UnknownScenarioError
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.suggestion import suggestion

MANY = """
schema_version = 1
name = "many"
title = "Many errors"
rate_hz = 5
duraton_s = 3
plant = {model = "damped-pont", x0 = "soon"}
operator = {source = {kind = "constnt"}}

[filter]
k_i = 100
mod = "off"

[[filter.barriers]]
kind = "disk-keep-out"
name = "disk"
center = [0, 0]
radius = true
motion = {kind = "swingg"}
class_k = [{kind = "linear", gain = -1}]

[[filter.barriers]]
name = "disk"

[links]
plant-to-filtr = {delay_s = 1}
plant-to-filter = {distribution = "histogram"}
"""

PROBLEMS = [
    "duration_s: got nothing, allowed a value: this key is required",
    "rate_hz: got 5, allowed at least 10",
    "plant.model: got 'damped-pont', allowed 'damped-point', … ; did you mean damped-point?",
    "plant.x0: got 'soon', allowed a list",
    "operator.source.kind: got 'constnt', allowed … ; did you mean constant?",
    "filter.barriers.0.class_k.0.gain: got -1, allowed above 0",
    "filter.barriers.0.motion.kind: got 'swingg', allowed travel, swing, circle; did you mean swing?",
    "filter.barriers.0.centre: got nothing, allowed a value: this key is required",
    "filter.barriers.0.radius: got true, allowed a number",
    "filter.barriers.0.center: got an unknown key, allowed kind, name, class_k, … ; did you mean centre?",
    "filter.barriers.1.kind: got nothing, allowed disk-keep-out, …",
    "filter.mod: got an unknown key, allowed law, mode, … ; did you mean mode?",
    "links.plant-to-filtr: got an unknown key, allowed operator-to-filter, … ; did you mean plant-to-filter?",
    "links.plant-to-filter.quantiles_s: got (), allowed 2 to 64 non-decreasing numbers …",
    "duraton_s: got an unknown key, allowed schema_version, … ; did you mean duration_s?",
]
"""Every line; … stands for the middle of a list."""


def test_scenario_with_many_errors_reports_all_of_them() -> None:
    with pytest.raises(ScenarioError) as refused:
        scenario_from(tomllib.loads(MANY), "many.toml")

    first, *lines = str(refused.value).splitlines()
    assert first == f"scenario many.toml: {len(PROBLEMS)} errors"
    assert len(lines) == len(PROBLEMS)
    for line, problem in zip(lines, PROBLEMS, strict=True):
        start, *rest = problem.split("…")
        assert line.startswith(f"  {start}")
        assert line.endswith(rest[-1].strip() if rest else problem)
    assert (refused.value.field, refused.value.got) == ("duration_s", "nothing")


def test_scenario_with_one_error_reports_it_in_one_line() -> None:
    with pytest.raises(ScenarioError) as refused:
        load_scenario("notomista-cai-2020", {"filter.mod": "off"})

    assert str(refused.value).startswith("scenario notomista-cai-2020: filter.mod: got an unknown key, allowed law, ")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("overrides", "field", "words"),
    [
        ({"fliter.mode": "off"}, "fliter", "did you mean filter?"),
        ({"links.plant-to-filter.dely_s": 1}, "links.plant-to-filter.dely_s", "did you mean delay_s?"),
        ({"filter.barriers.dsk.radius": 1}, "filter.barriers.dsk.radius", "did you mean disk?"),
        ({"filter.law": "sampld"}, "filter.law", "did you mean sampled?"),
        ({"filter": 3}, "filter", "a table"),
        ({"title": 3}, "title", "text in quotes"),
        ({"filter.prediction": "perhaps"}, "filter.prediction", "true or false"),
        ({"filter.repeats": 1.5}, "filter.repeats", "a whole number"),
        ({"filter.k_i": float("nan")}, "filter.k_i", "a finite number"),
        ({"name": "Two Words"}, "name", "text that matches"),
        ({"filter.k_i": 2000.0}, "filter.k_i", "below rate_hz"),
    ],
)
def test_override_that_cannot_be_is_reported_in_words(overrides: dict[str, object], field: str, words: str) -> None:
    with pytest.raises(ScenarioError) as refused:
        load_scenario("notomista-cai-2020", overrides)

    assert refused.value.field == field
    assert words in refused.value.allowed


def test_misspelt_scenario_suggests_the_shipped_one() -> None:
    with pytest.raises(UnknownScenarioError, match=r"; did you mean notomista-cai-2020\?$"):
        load_scenario("notomista-cai-2002")


def test_misspelt_link_suggests_the_link() -> None:
    with pytest.raises(LinkNameError, match=r"; did you mean plant-to-filter\?$"):
        require_links(["plant-filter"])


def test_misspelt_parameter_suggests_that_of_the_model() -> None:
    scenario = load_scenario("notomista-cai-2020", {"plant.parameters": {"sgima": 1.0}})

    with pytest.raises(ScenarioError, match=r"plant.parameters: got sgima, allowed sigma, mass; did you mean sigma\?"):
        robot_of(scenario)


def test_name_unlike_all_others_gets_no_suggestion(tmp_path: Path) -> None:
    assert suggestion("zzz", ("delay", "loss")) == ""
    with pytest.raises(UnknownScenarioError) as refused:
        load_scenario(str(tmp_path / "none.toml"))
    assert "did you mean" not in str(refused.value)


@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("schema_version", True, "schema_version: got true, allowed a whole number"),
        ("filter.k_i", True, "filter.k_i: got true, allowed a number"),
        ("filter.k_i", "60", "filter.k_i: got '60', allowed a number"),
        ("filter.k_i", 10**400, f"filter.k_i: got 1{'0' * 58}…, allowed a number"),
        ("plant.x0", [0, True, "1", 0.5], "plant.x0.1: got true, allowed a number"),
        ("links.plant-to-filter.queue", 2.0, "links.plant-to-filter.queue: got 2.0, allowed a whole number"),
        ("filter.prediction", 1, "filter.prediction: got 1, allowed true or false"),
        ("operator.source", [["a"] * 3] * 100, "operator.source: got [['a', 'a', 'a'],"),
    ],
)
def test_nothing_is_converted(key: str, value: object, problem: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        load_scenario("notomista-cai-2020", {key: value})

    assert problem in str(caught.value)


def test_whole_numbers_are_numbers() -> None:
    scenario = load_scenario("notomista-cai-2020", {"filter.k_i": 60, "plant.x0": [-3, 0, 0, 0]})

    assert (scenario.filter.k_i, scenario.plant.x0) == (60.0, (-3.0, 0.0, 0.0, 0.0))


def test_lists_without_end_are_refused() -> None:
    deep: object = 0.0
    for _ in range(500):
        deep = [deep]
    with pytest.raises(ScenarioError):
        load_scenario("notomista-cai-2020", {"plant.x0": deep})
