from pathlib import Path

import pytest
from passafe_services.scenarios.errors import ScenarioError, UnknownScenarioError, UnreadableScenarioError
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.scenarios.schema import Scenario

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


def test_truncated_file_is_reported_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "torn.toml"
    path.write_text("name = [", encoding="utf-8")

    with pytest.raises(UnreadableScenarioError, match=r"torn\.toml"):
        load_scenario(str(path))


def test_folder_that_may_not_be_searched_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: Path) -> bool:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "is_file", refuse)  # the superuser may search every folder

    with pytest.raises(UnreadableScenarioError, match=r"mine\.toml.*Permission denied"):
        load_scenario(str(tmp_path / "mine.toml"))


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


def test_an_entry_of_a_list_is_reached_by_number_or_by_name() -> None:
    gains = {"filter.barriers.disk.class_k.2.gain": 7.0, "filter.barriers.0.radius": 0.5, "plant.x0.3": -0.25}

    scenario = load_scenario(NAME, gains)

    [disk] = scenario.filter.barriers
    assert [gamma.gain for gamma in disk.class_k] == [10.0, 10.0, 7.0]
    assert getattr(disk, "radius", None) == 0.5
    assert scenario.plant.x0 == (2.0, 2.0, -1.0, -0.25)


@pytest.mark.parametrize("dotted", ["filter.barriers.disc.radius", "filter.barriers.1.radius", "plant.x0.4", "name.x"])
def test_unknown_override_name_is_reported(dotted: str) -> None:
    with pytest.raises(ScenarioError, match="allowed") as refusal:
        load_scenario(NAME, {dotted: 1.0})

    assert refusal.value.field == dotted


def test_two_barriers_may_not_share_a_name() -> None:
    barrier = load_scenario(NAME).filter.barriers[0].model_dump()

    with pytest.raises(ScenarioError, match="each name once"):
        load_scenario(NAME, {"filter.barriers": [barrier, barrier]})


def test_the_schema_refuses_what_is_not_in_it() -> None:
    assert Scenario.model_config["extra"] == "forbid"
