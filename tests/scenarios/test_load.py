from pathlib import Path

import pytest

from services.scenarios.errors import ScenarioError, UnknownScenarioError, UnreadableScenarioError
from services.scenarios.load import load_scenario, shipped_scenarios
from services.scenarios.schema import Scenario

NAME = "notomista-cai-2020"


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_shipped_scenario_loads_under_its_own_name(name: str) -> None:
    assert load_scenario(name).name == name


def test_an_unknown_name_lists_what_there_is() -> None:
    with pytest.raises(UnknownScenarioError, match=NAME):
        load_scenario("nonsense")


def test_a_scenario_survives_json(tmp_path: Path) -> None:
    scenario = load_scenario(NAME)
    path = tmp_path / "effective.json"
    path.write_text(scenario.model_dump_json(), encoding="utf-8")

    assert load_scenario(str(path)) == scenario


def test_a_torn_file_is_told_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "torn.toml"
    path.write_text("name = [", encoding="utf-8")

    with pytest.raises(UnreadableScenarioError, match=r"torn\.toml"):
        load_scenario(str(path))


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("rate_hz", -5),
        ("rate_hz", "fast"),
        ("duration_s", 0),
        ("filter.mode", "sometimes"),
        ("filter.k_i", 2000.0),
        ("filter.input_bound", float("nan")),
        ("plant.model", "unicorn"),
        ("plant.colour", "red"),
        ("links.nowhere", {"delay_s": 1}),
        ("links.plant-to-filter", {"loss": 1.5}),
        ("operator.source", {"kind": "telepathy"}),
        ("filter.barriers", [{"kind": "disk-keep-out", "name": "a", "centre": [0, 0], "radius": -1, "class_k": []}]),
    ],
)
def test_nonsense_names_the_field(field: str, value: object) -> None:
    with pytest.raises(ScenarioError) as refusal:
        load_scenario(NAME, {field: value})

    assert str(refusal.value).count("\n") == 0 or "allowed" in str(refusal.value)
    assert field.split(".", maxsplit=1)[0] in refusal.value.field or field.rpartition(".")[2] in str(refusal.value)


def test_two_barriers_may_not_share_a_name() -> None:
    barrier = load_scenario(NAME).filter.barriers[0].model_dump()

    with pytest.raises(ScenarioError, match="each name once"):
        load_scenario(NAME, {"filter.barriers": [barrier, barrier]})


def test_the_schema_refuses_what_is_not_in_it() -> None:
    assert Scenario.model_config["extra"] == "forbid"
