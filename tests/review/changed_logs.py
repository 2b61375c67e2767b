"""Logs of which messages are changed, with all checksums right."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msgspec.structs import replace
from passafe_protocol.codec import encode
from passafe_protocol.messages import (
    Header,
    Message,
)
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log.log_pass import LogPass
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_review import RunReview, identity_of
from passafe_services.tools.review.verdict import Verdict

AGREE = (
    "states-agree",
    "inputs-agree",
    "predictions-agree",
    "decisions-agree",
    "ticks-agree",
    "tank-agrees",
    "scenario-agrees",
)
STEPS = 400


def metadata_of(scenario: Scenario) -> dict[str, dict[str, str]]:
    return run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")


def loaded(name: str, changes: dict[str, Any] | None = None) -> Scenario:
    return load_scenario(name, changes)


def recorded(path: Path, scenario: Scenario, steps: int = STEPS) -> list[tuple[Header, Message]]:
    with LogWriter(path, metadata_of(scenario)) as log:
        loop = lockstep_loop(scenario, observer=LockstepLog(log))
        loop.run(steps)
        loop.finish()
    return [(m.header, m.body) for m in LogPass(path).messages(*TOPIC_OF_BODY)]


def more(name: str, amount: int = 1) -> Callable[[Any], Any]:
    return lambda body: getattr(body, name) + amount


def verdict_on(path: Path) -> Verdict:
    run = LogPass(path)
    identity = identity_of(run)
    review = RunReview(path, identity, CoreEvaluator(identity.scenario))
    run.feed(review)
    return Verdict.concluding(review, run)


@dataclass
class Recorded:
    scenario: Scenario
    messages: list[tuple[Header, Message]]

    def write(
        self,
        path: Path,
        change: Callable[[Header, Any], Message] = lambda _header, body: body,
        metadata: Scenario | None = None,
    ) -> Path:
        with LogWriter(path, metadata_of(metadata or self.scenario)) as log:
            for header, body in self.messages:
                data = encode(header, change(header, body))
                log.write(TOPIC_OF_BODY[type(body)].key(header.source), data, sequence=header.sequence, wall_ns=5)
        return path


def walls_with(links: dict[str, dict[str, Any]], folder: Path) -> Recorded:
    scenario = Scenario.model_validate(loaded("walls-and-disks").model_dump(mode="json") | {"links": links})
    return Recorded(scenario, recorded(folder / "walls.mcap", scenario))


def of_all(kind: type[Message], **changes: Callable[[Any], object]) -> Callable[[Header, Any], Message]:
    """Change fields of every message of a kind, each by a function of the message."""

    def change(_header: Header, body: Any) -> Message:  # noqa: ANN401 - of the kind asked for
        return replace(body, **{name: of(body) for name, of in changes.items()}) if type(body) is kind else body

    return change


def of_one(kind: type[Message], **changes: Callable[[Any], object]) -> Callable[[Header, Any], Message]:
    """Change fields of message 200 of a kind."""
    every = of_all(kind, **changes)
    return lambda header, body: every(header, body) if header.sequence == 200 else body


def plus(name: str, amount: float) -> Callable[[Any], tuple[float, ...]]:
    return lambda body: (getattr(body, name)[0] + amount, *getattr(body, name)[1:])
