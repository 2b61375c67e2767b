"""Logs of which numbers were changed, with all checksums right: what can be recomputed is, and the change is named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from changed_logs import AGREE, Recorded, loaded, of_all, of_one, plus, recorded, verdict_on
from msgspec.structs import replace
from passafe_protocol.messages import (
    FilterStatus,
    FilterTick,
    Header,
    Message,
    PlantInput,
    PlantPhase,
    PlantState,
    ScenarioInfo,
)
from passafe_services.scenarios.schema import Scenario


@pytest.fixture(scope="module")
def walls(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    scenario = loaded("walls-and-disks")
    return Recorded(scenario, recorded(tmp_path_factory.mktemp("log") / "walls.mcap", scenario))


def later_energy(header: Header, body: Message) -> Message:
    if type(body) is not PlantState or header.sequence < 200:
        return body
    return replace(body, energy_in_j=body.energy_in_j + 100.0)


def first_barrier(body: FilterTick) -> tuple[Any, ...]:
    first, *others = body.barriers
    return replace(first, psi=(first.psi[0] + 1e-2, *first.psi[1:])), *others


def first_row(**changes: float) -> Callable[[FilterTick], tuple[Any, ...]]:
    def change(body: FilterTick) -> tuple[Any, ...]:
        first, *others = body.rows
        return replace(first, **{name: getattr(first, name) + more for name, more in changes.items()}), *others

    return change


CHANGES: dict[str, tuple[Callable[[Header, Any], Message], str, str]] = {
    "energy in later states": (later_energy, "states-agree", "energy supplied"),
    "energy in all states": (of_all(PlantState, energy_in_j=lambda b: b.energy_in_j + 100), "states-agree", "start"),
    "output of one state": (of_one(PlantState, y=plus("y", 1.0)), "states-agree", "output y"),
    "stored energy of one state": (
        of_one(PlantState, energy_stored_j=lambda b: b.energy_stored_j + 1e-3),
        "states-agree",
        "stored energy",
    ),
    "x of one state": (of_one(PlantState, x=plus("x", 1e-3)), "states-agree", "stored energy"),
    "all phases": (
        of_all(PlantState, phase=lambda _: PlantPhase.RUNNING),
        "predictions-agree",
        "no input of the filter",
    ),
    "u of one input": (of_one(PlantInput, u=plus("u", 1.0)), "inputs-agree", "u differs by 1"),
    "time of one input": (
        of_one(PlantInput, effective_plant_ns=lambda b: b.effective_plant_ns + 10**6),
        "inputs-agree",
        "time of effect",
    ),
    "applied tick of one state": (
        of_one(PlantState, applied_tick=lambda b: b.applied_tick - 1),
        "predictions-agree",
        "time of effect",
    ),
    "u of one tick": (of_one(FilterTick, u=plus("u", 1.0)), "inputs-agree", "u differs by 1"),
    "u of one tick, derived": (of_one(FilterTick, u=plus("u", 1.0)), "decisions-agree", "tick 2"),
    "x̂ of one tick": (of_one(FilterTick, x_hat=plus("x_hat", 1e-2)), "predictions-agree", "predicted state"),
    "ψ of one tick": (of_one(FilterTick, barriers=first_barrier), "decisions-agree", "ψ differs"),
    "tank of one tick": (of_one(FilterTick, tank_j=lambda b: b.tank_j + 0.1), "tank-agrees", "tank differs"),
    "tank of all ticks": (of_all(FilterTick, tank_j=lambda b: b.tank_j + 0.1), "tank-agrees", "tick 1: tank"),
    "status of one tick": (
        of_one(
            FilterTick,
            status=lambda b: FilterStatus.PASSED if b.status is FilterStatus.MODIFIED else FilterStatus.MODIFIED,
        ),
        "decisions-agree",
        "derived",
    ),
    "slack of one tick": (of_one(FilterTick, slack=lambda b: b.slack + 0.1), "decisions-agree", "slack"),
    "margin of one row": (of_one(FilterTick, rows=first_row(margin=0.1)), "decisions-agree", "margin of a row"),
    "dual of one row": (of_one(FilterTick, rows=first_row(dual=0.1)), "decisions-agree", "dual of a row"),
    "û of one tick": (of_one(FilterTick, u_nominal=plus("u_nominal", 0.1)), "decisions-agree", "u_nominal"),
    "power margin of one tick": (
        of_one(FilterTick, power_margin=lambda b: b.power_margin + 0.1),
        "decisions-agree",
        "power margin",
    ),
    "mode of one tick": (of_one(FilterTick, mode=lambda _: "off"), "decisions-agree", "mode is not"),
    "published scenario": (
        of_all(ScenarioInfo, scenario_json=lambda b: b.scenario_json.replace('"input_bound":', '"input_bound":1')),
        "scenario-agrees",
        "input_bound",
    ),
}


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_is_found_and_named(walls: Recorded, name: str, tmp_path: Path) -> None:
    change, property_name, part = CHANGES[name]
    verdict = verdict_on(walls.write(tmp_path / "changed.mcap", change))

    entry = verdict.properties[property_name]
    assert entry.holds is False
    assert part in entry.note
    assert entry.violations
    assert verdict.verdict == "fails"
    assert part in verdict.words


@pytest.mark.parametrize("keys", [{"mode": "off"}, {"barriers": []}])
def test_metadata_beside_the_published_scenario(walls: Recorded, keys: dict[str, Any], tmp_path: Path) -> None:
    content = walls.scenario.model_dump(mode="json")
    content["filter"] |= keys
    verdict = verdict_on(walls.write(tmp_path / "changed.mcap", metadata=Scenario.model_validate(content)))

    assert verdict.properties["scenario-agrees"].holds is False
    assert next(iter(keys)) in verdict.properties["scenario-agrees"].note
    assert verdict.verdict == "fails"


def test_an_unchanged_log_agrees(walls: Recorded, tmp_path: Path) -> None:
    verdict = verdict_on(walls.write(tmp_path / "same.mcap"))

    assert {name: verdict.properties[name].holds for name in AGREE} == dict.fromkeys(AGREE, True)
    assert verdict.verdict == "holds"


@pytest.mark.parametrize(
    ("name", "links"),
    [
        ("lagged-point", {}),
        ("moving-disk", {"filter-to-plant": {"loss": 0.3, "delay_s": 0.02}}),
        ("two-robots", {"plant-to-filter": {"delay_s": 0.1, "jitter_s": 0.05, "loss": 0.2}}),
    ],
)
def test_honest_logs_raise_no_alarm(name: str, links: dict[str, Any], tmp_path: Path) -> None:
    content = loaded(name).model_dump(mode="json")
    content["links"] = content.get("links", {}) | links
    path = tmp_path / "run.mcap"
    recorded(path, Scenario.model_validate(content))
    verdict = verdict_on(path)

    assert {n: verdict.properties[n].note for n in AGREE if verdict.properties[n].holds is not True} == {}
