"""Schema of experiment files and its error messages."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.tools.experiment.axes import ChoiceAxis, LogUniformAxis, UniformAxis
from passafe_services.tools.experiment.cells import cells_of, run_of
from passafe_services.tools.experiment.check import check
from passafe_services.tools.experiment.errors import ExperimentError, UnknownExperimentError, UnreadableExperimentError
from passafe_services.tools.experiment.load import experiment_from, load_study, shipped_experiments
from passafe_services.tools.experiment.schema import Experiment
from studies import DELAY, NAME, study

LEAST = {"schema_version": 2, "name": "small", "title": "Small", "scenario": NAME}
BISECTED = {"name": "d", "kind": "bisect", "key": "plant.hold_s", "low": 0.0, "high": 1.0, "steps": 3}


def experiment(**fields: object) -> Experiment:
    return experiment_from(LEAST | fields, "small.toml")


@pytest.mark.parametrize("name", shipped_experiments())
def test_every_shipped_experiment_can_be_built(name: str) -> None:
    loaded = load_study(name)

    check(loaded)

    assert loaded.experiment.name == name


def test_a_linked_axis_sets_all_its_keys_and_may_scale_them() -> None:
    both = experiment(axes=[{"name": "delay_s", "keys": {"a.x": 1.0, "b.y": 0.5}, "values": [0.2]}])

    assert both.overrides_of("base", {"delay_s": 0.2}) == {"a.x": 0.2, "b.y": 0.1}


def test_axes_override_the_variant_and_that_the_experiment() -> None:
    layered = experiment(
        overrides={"a": 1, "b": 1, "c": 1}, variants={"v": {"b": 2, "c": 2}}, axes=[{"key": "c", "values": [3]}]
    )

    assert layered.overrides_of("v", {"c": 3}) == {"a": 1, "b": 2, "c": 3}


def test_cells_are_every_combination_of_listed_values() -> None:
    axes = [DELAY, {"key": "k", "values": [1, 2, 3]}, {"key": "r", "kind": "uniform", "low": 0, "high": 1}]
    swept = experiment(axes=axes, variants={"off": {}, "both": {}}, seeds={"first": 5, "count": 3})
    cells = cells_of(swept)

    assert len(cells) == 2 * 2 * 3
    assert [cell.number for cell in cells] == list(range(12))
    assert [cell.values for cell in cells[:4]] == [
        {"delay_s": 0.0, "k": 1},
        {"delay_s": 0.0, "k": 2},
        {"delay_s": 0.0, "k": 3},
        {"delay_s": 0.01, "k": 1},
    ]
    drawn = [[run_of(swept, cell, seed).values["r"] for cell in cells] for seed in (5, 6)]
    assert len(set(drawn[0])) == len(set(drawn[1])) == 1
    assert drawn[0][0] != drawn[1][0]


def test_what_is_drawn_has_its_distribution() -> None:
    uniform = UniformAxis(key="a", kind="uniform", low=2.0, high=4.0)
    log = LogUniformAxis(key="a", kind="log-uniform", low=0.01, high=1.0)
    choice = ChoiceAxis(key="a", kind="choice", values=("x", "y"))
    seeds = range(2000)
    u, g = np.array([uniform.draw(k) for k in seeds]), np.array([log.draw(k) for k in seeds])
    x = np.mean([choice.draw(k) == "x" for k in seeds])

    # Four standard errors: of a mean of a uniform variable of width 2, of one of shares of one half.
    assert abs(u.mean() - 3.0) < 4 * (2 / np.sqrt(12)) / np.sqrt(2000)
    assert 2.0 <= u.min() < 2.01
    assert 3.99 < u.max() <= 4.0
    assert abs(np.mean(g < 0.1) - 0.5) < 4 * 0.5 / np.sqrt(2000)
    assert abs(x - 0.5) < 4 * 0.5 / np.sqrt(2000)


def test_another_seed_or_name_of_an_axis_draws_other_values() -> None:
    def drawn(name: str, seed: int) -> object:
        return UniformAxis(name=name, key="a", kind="uniform", low=0, high=1, seed=seed).draw(7)

    assert drawn("a", 0) == drawn("a", 0)
    assert len({drawn("a", 0), drawn("a", 1), drawn("b", 0)}) == 3


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"colour": "red"}, "colour"),
        ({"seeds": {"count": 0}}, "seeds.count: got 0"),
        ({"start": "nowhere"}, "start: got 'nowhere'"),
        ({"axes": [{"key": "a", "values": []}]}, "axes.0.values: got [], allowed a list no shorter than 1"),
        ({"axes": [{"key": "a", "values": [1, 1]}]}, "allowed each value once"),
        ({"axes": [{"values": [1]}]}, "key, keys: got both or neither"),
        ({"axes": [{"keys": ["a", "b"], "values": [1]}]}, "name: got none"),
        ({"axes": [{"name": "n", "keys": {"a": 2.0}, "values": ["x"]}]}, "allowed numbers"),
        ({"axes": [{"key": "a", "kind": "zigzag"}]}, "zigzag"),
        ({"axes": [{"key": "a", "kind": "uniform", "low": 1, "high": 1}]}, "low, high: got 1 and 1"),
        ({"axes": [BISECTED | {"tolerance": 0.1}]}, "tolerance, steps: got both"),
        ({"axes": [BISECTED, BISECTED | {"name": "e", "key": "plant.playout_s"}]}, "several that are bisected"),
        ({"axes": [DELAY, DELAY]}, "'delay_s', allowed each name once"),
        ({"axes": [DELAY, {"name": "b", "key": "links.plant-to-filter.delay_s", "values": [1]}]}, "in two of them"),
        ({"axes": [{"name": "h_min", "key": "a", "values": [1]}]}, "'h_min'"),
        ({"axes": [{"key": f"k{n}", "values": list(range(200))} for n in range(3)]}, "8000000 cells"),
        ({"seeds": {"count": 600_000}, "axes": [DELAY]}, "1200000 runs"),
        ({"overrides": {"filter": {"mode": "off"}}}, "dotted names in quotes"),
        ({"variants": {"off": {"filter": {"mode": "off"}}}}, "dotted names in quotes"),
        ({"variants": {}}, "variants"),
        ({"criteria": {"a": {"metric": "beauty", "at_least": 0}}}, "metric: got 'beauty', allowed one of duration_s"),
        ({"criteria": {"a": {"metric": "h_max", "at_least": 0}}}, "did you mean h_min?"),
        ({"sedes": {"count": 2}}, "did you mean seeds?"),
        ({"criteria": {"a": {"metric": "h_min"}}}, "at_least, at_most: got both or neither"),
        ({"criteria": {"a": {"metric": "tracking_max", "at_most": 1}}}, "tracking = true"),
        ({"worst_by": "beauty"}, "worst_by: got 'beauty', allowed one of safe, solvent"),
    ],
)
def test_nonsense_names_field_value_and_what_is_allowed(fields: dict[str, Any], expected: str) -> None:
    with pytest.raises(ExperimentError) as refusal:
        experiment(**fields)

    assert expected in str(refusal.value)
    assert str(refusal.value).startswith("experiment small.toml: ")
    assert " allowed " in str(refusal.value)


def test_files_are_found_by_name_or_path(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        'schema_version = 2\nname = "mine"\ntitle = "Mine"\nscenario = "own.json"\n', encoding="utf-8"
    )
    with pytest.raises(ScenarioError, match=r"own\.json"):
        load_study(str(tmp_path / "mine.toml"))
    (tmp_path / "own.json").write_text(study().scenario_with({}).model_dump_json(), encoding="utf-8")

    assert load_study(str(tmp_path / "mine.toml")).scenario_with({"duration_s": 3.0}).duration_s == 3.0


def test_missing_and_torn_files_are_reported(tmp_path: Path) -> None:
    (tmp_path / "torn.toml").write_text("name = [", encoding="utf-8")

    with pytest.raises(UnreadableExperimentError, match=r"torn\.toml"):
        load_study(str(tmp_path / "torn.toml"))
    with pytest.raises(
        UnknownExperimentError, match="allowed a TOML file or one of bad-network, bad-network-walls, delay"
    ):
        load_study("nonsense")


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"axes": [{"key": "links.plant-to-filter.delay_s", "values": [0.0, 11.0]}]}, "delay_s: got 11.0"),
        ({"axes": [BISECTED | {"high": 3.0}]}, "plant.hold_s: got 3.0"),
        ({"variants": {"a": {}, "b": {"filter.mode": "maybe"}}}, "filter.mode: got 'maybe'"),
        ({"overrides": {"filter.barriers.disc.radius": 1.0}}, "filter.barriers.disc.radius: got 'disc', allowed disk"),
    ],
)
def test_a_refused_scenario_value_is_reported_before_any_run(fields: dict[str, Any], expected: str) -> None:
    with pytest.raises(ScenarioError) as refusal:
        check(study(**fields))

    assert expected in str(refusal.value)
