"""Logs of short runs, and ends of runs, for the tests of demos."""

from collections.abc import Callable
from pathlib import Path

from msgspec.structs import replace
from passafe_protocol.messages import Header, Message, ScenarioInfo
from passafe_protocol.topics import Topic
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.loop.process_exit import Exit, ExitCause, RunOutcome
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop

RUN_S = 0.3


def _as_live(write: LockstepLog) -> Callable[[Topic, Header, Message], None]:
    """Return an observer that logs what a live filter publishes of its driver."""

    def observe(topic: Topic, header: Header, body: Message) -> None:
        write(topic, header, replace(body, driver="live") if isinstance(body, ScenarioInfo) else body)

    return observe


def write_log(path: Path, scenario: Scenario, *, planned_s: float | None = RUN_S, finished: bool = True) -> Path:
    text = scenario.model_dump_json()
    metadata = run_metadata(scenario_json=text, versions=versions(), driver="live", planned_s=planned_s)
    log = LogWriter(path, metadata)
    lockstep_loop(scenario, observer=_as_live(LockstepLog(log))).run(round((RUN_S + 0.1) * scenario.rate_hz))
    log.flush()
    torn = path.read_bytes()
    log.close()
    if not finished:
        path.write_bytes(torn)
    return path


def ended(cause: ExitCause, culprit: str | None, *, returncode: int = 0) -> RunOutcome:
    exits = (Exit(name=culprit, returncode=returncode, requested=False, killed=False),) if culprit else ()
    return RunOutcome(cause=cause, culprit=culprit, detail=f"{culprit} ended", exits=exits)
