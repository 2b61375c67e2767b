"""Changes of what inputs, links and configurations report are found and named."""

from collections.abc import Callable
from typing import Any

import pytest
from changed_logs import Recorded, more, of_all, of_one, plus, verdict_on, walls_with
from msgspec.structs import replace
from passafe_protocol.messages import Header, LinkEvent, LinkState, Message, PlantInput, ScenarioInfo
from passafe_services.tools.review.run_identity import RunIdentity
from passafe_services.tools.review.scenario_check import ScenarioCheck

Change = Callable[[Header, Any], Message]

LINKS = {
    "plant-to-filter": {"delay_s": 0.02, "loss": 0.1},
    "filter-to-plant": {"delay_s": 0.02, "loss": 0.1, "duplicate": 0.1},
}


@pytest.fixture(scope="module")
def walls(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return walls_with(LINKS, tmp_path_factory.mktemp("log"))


def of_link(**changes: Callable[[Any], object]) -> Change:
    """Change the first state and every event of the link from the plant to the filter."""

    def change(_header: Header, body: Any) -> Message:  # noqa: ANN401 - of every kind
        if not isinstance(body, LinkState | LinkEvent) or body.link != "plant-to-filter":
            return body
        if isinstance(body, LinkState) and body.trigger != "start":
            return body
        known = {name: of(body) for name, of in changes.items() if hasattr(body, name)}
        return replace(body, **known)

    return change


def settings(**changes: object) -> Callable[[Any], object]:
    return lambda body: replace(body.parameters, **changes)


INPUTS: dict[str, tuple[Change, str]] = {
    "hold": (of_one(PlantInput, hold_ns=more("hold_ns")), "another hold time"),
    "hold of all": (of_all(PlantInput, hold_ns=more("hold_ns")), "another hold time"),
    "start of the sequence": (of_one(PlantInput, input_sequence_start_ns=more("input_sequence_start_ns")), "began at"),
    "known break": (of_one(PlantInput, known_break_ns=more("known_break_ns")), "another sequence break"),
    "stops": (of_one(PlantInput, stops_cleared=more("stops_cleared")), "stops_cleared goes back"),
    "copies": (of_one(PlantInput, previous_u=plus("previous_u", 1e-9)), "copies of other inputs"),
    "no copies": (of_one(PlantInput, previous_u=lambda _: ()), "copies of other inputs"),
}
CONTRADICTIONS: dict[str, tuple[Change, str]] = {
    "topic": (of_link(topic=lambda _: "tick"), "states of another topic"),
    "topic of events": (of_link(topic=lambda _: "tick"), "events of messages that were not sent"),
    "delay": (of_link(parameters=settings(delay_s=0.01)), "settings of nobody"),
    "loss": (of_link(parameters=settings(loss=0.01)), "settings of nobody"),
    "delivered": (of_link(delivered=more("delivered")), "balance of a state"),
    "refused": (of_link(refused_corrupted=more("refused_corrupted")), "neither corrupted nor copies"),
    "request": (of_link(config_sequence=more("config_sequence")), "requests of nobody"),
    "trace": (of_link(trace_opportunities=more("trace_opportunities")), "traces that"),
    "end": (of_link(trigger=lambda _: "end"), "ends without a beginning"),
}


@pytest.mark.parametrize("name", INPUTS)
def test_a_change_of_an_input_is_named(walls: Recorded, name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    change, part = INPUTS[name]
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "changed.mcap", change))

    assert verdict.properties["inputs-agree"].holds is False
    assert part in verdict.properties["inputs-agree"].note


@pytest.mark.parametrize("name", CONTRADICTIONS)
def test_states_that_contradict_are_named(walls: Recorded, name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    change, part = CONTRADICTIONS[name]
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "changed.mcap", change))

    assert verdict.properties["links-reconciled"].holds is False
    assert verdict.verdict != "holds"
    assert any(part in what for account in verdict.links for what in account.differences)


def test_a_drop_of_a_message_that_was_consumed(walls: Recorded, tmp_path_factory: pytest.TempPathFactory) -> None:
    change = of_link(sequence=more("sequence"))
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "changed.mcap", change))

    assert "consumed that its link dropped" in verdict.properties["ticks-agree"].note


def test_another_driver_was_published(walls: Recorded, tmp_path_factory: pytest.TempPathFactory) -> None:
    change = of_all(ScenarioInfo, driver=lambda _: "live")
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "changed.mcap", change))

    assert "the log has lockstep, the filter published live" in verdict.properties["scenario-agrees"].note


def test_other_versions_were_published(walls: Recorded) -> None:
    info = next(body for _, body in walls.messages if isinstance(body, ScenarioInfo))
    identity = RunIdentity.model_validate(
        {"scenario": info.scenario_json, "driver": "lockstep", "versions": info.versions_json}
    )
    check = ScenarioCheck(identity.model_copy(update={"versions": {**identity.versions, "numpy": "9.9"}}))
    check.compare("scenario 0", info)

    assert "version of numpy: the log has 9.9" in check.agreement.property().note


def test_an_unchanged_log_agrees(walls: Recorded, tmp_path_factory: pytest.TempPathFactory) -> None:
    verdict = verdict_on(walls.write(tmp_path_factory.mktemp("log") / "same.mcap"))

    assert verdict.verdict == "holds"
    assert verdict.properties["inputs-agree"].note == ""
