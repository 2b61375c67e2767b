"""The closed-form run as a log, and the record of it that a report is made of."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from closed_form import MS, ClosedFormRun, header, paper_scenario
from passafe_dashboard.run_record.collector import RunCollector
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header, Message, PlantPhase, PlantState
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log.log_pass import LogPass
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_identity import identify


def write_log(path: Path, messages: Sequence[tuple[Header, Message]], scenario: Scenario | None = None) -> Path:
    """Write messages as the log of a run."""
    scenario = paper_scenario() if scenario is None else scenario
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={"passafe": "1"}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        for head, body in messages:
            key = TOPIC_OF_BODY[type(body)].key(head.source)
            writer.write(key, encode(head, body), sequence=head.sequence, wall_ns=head.wall_ns)
    return path


def circle_messages(duration_ms: int) -> list[tuple[Header, Message]]:
    """Messages of the run, with wall times, and a fail-safe of 10 ms with a warning after 0.2 s."""
    messages: list[tuple[Header, Message]] = []
    for head, body, at_ns in ClosedFormRun().until(duration_ms * MS):
        timed = Header(head.source, head.epoch, head.sequence, at_ns, at_ns, at_ns, at_ns)
        if isinstance(body, PlantState) and 200 * MS <= body.plant_ns < 210 * MS:
            body = with_phase(body, PlantPhase.FAIL_SAFE)  # noqa: PLW2901 - stands in for what was recorded
        messages.append((timed, body))
    messages.append((header("plant", 0, at_ns=200 * MS), Event("warning", "no input: <b>fail-safe</b>")))
    return messages


def with_phase(state: PlantState, phase: PlantPhase) -> PlantState:
    values: dict[str, Any] = {name: getattr(state, name) for name in state.__struct_fields__}
    return PlantState(**(values | {"phase": phase}))


def record_of(path: Path) -> RunCollector:
    """Return the record of a log."""
    log = LogPass(path)
    scenario = identify(path, log.metadata, None).scenario
    record = RunCollector(scenario, CoreEvaluator(scenario))
    log.feed(record)
    return record


def circle_record(folder: Path, duration_ms: int = 2_000) -> RunCollector:
    """Return the record of the closed-form run, its log in a folder."""
    return record_of(write_log(folder / "circle.mcap", circle_messages(duration_ms)))
