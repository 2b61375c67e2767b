"""A what-if: the re-run of a log under changed conditions, as a log of its own, and what differs."""

from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256
from json import dumps
from pathlib import Path
from typing import Final

from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic
from pydantic import BaseModel, ConfigDict

from passafe_services.log.log_file import in_place_of
from passafe_services.log.log_files import files_of
from passafe_services.log.log_writer import DRIVER_RECORD, LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.simulation import CompiledScenario
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.causes import Causes
from passafe_services.tools.what_if.changes import changes_between
from passafe_services.tools.what_if.divergence import DivergenceWatch, FirstDifference
from passafe_services.tools.what_if.recorded_run import RecordedRun
from passafe_services.tools.what_if.rerun import Conditions, rerun_loop

WHAT_IF_RECORD: Final = "what-if"
"""Metadata record of a log that a what-if wrote: what it was made from."""

OPEN_LOOP: Final = "the operator's commands are those of the log: the person does not react to what happens here"
CLOSED_LOOP: Final = "operator in closed loop"

Progress = Callable[[int, int], object]
"""Called with the steps of the plant that are done, and all of them."""


class Exactness(BaseModel):
    """Agreement of a re-run with its log, by topic.

    Attributes:
        compared: Messages of the re-run.
        identical: Those that are the same to the last bit in the log.
        only_in_log: Messages that only the log has.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    compared: dict[str, int]
    identical: dict[str, int]
    only_in_log: dict[str, int]


class WhatIf(BaseModel):
    """Result of a what-if, besides its log.

    Attributes:
        source: Log that was re-run.
        source_digest: SHA-256 of its files.
        changes: What was changed, in words.
        operator: Who drives, in words.
        links: What links do, in words.
        is_exact: Whether all ticks and states are those of the log, to the last bit.
        exactness: The same by topic.
        first_difference: First message that differs.
        first_motion: First state in which the robot is elsewhere.
        doubts: What the log does not show.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    source: str
    source_digest: str
    changes: tuple[str, ...]
    operator: str
    links: str
    is_exact: bool
    exactness: Exactness
    first_difference: FirstDifference | None
    first_motion: FirstDifference | None
    doubts: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class Question:
    """A log, ready to be re-run.

    Attributes:
        log: The log.
        run: What a re-run needs of it.
        digest: SHA-256 of its files.
    """

    log: RunLog
    run: RecordedRun
    digest: str

    @classmethod
    def of(cls, log: RunLog) -> "Question":
        """Prepare a log.

        Raises:
            RerunError: The log does not show what a re-run starts from.
        """
        digest = sha256()
        for path in files_of(log.path):
            with path.open("rb") as file:
                while block := file.read(1 << 20):
                    digest.update(block)
        return cls(log=log, run=RecordedRun.of(log), digest=digest.hexdigest())

    def answer(
        self,
        conditions: Conditions,
        out: Path,
        *,
        operator: str = "",
        compiled: CompiledScenario | None = None,
        progress: Progress | None = None,
    ) -> WhatIf:
        """Re-run the log, write the log of the re-run, and return what differs.

        Args:
            conditions: Conditions of the re-run.
            out: The log to write.
            operator: Who drives instead of the recorded commands, in words; empty: nobody.
            compiled: The compiled scenario, if there is one already.
            progress: Called now and then.

        Raises:
            LogWriteError: The log cannot be written.
            DesignError: A part of the design is not valid.
        """
        changes = changes_between(self.run.scenario, conditions.scenario)
        links = _links_in_words(conditions, self.run)
        drawn = links if conditions.links == "drawn" else ""
        watch = DivergenceWatch(self.log, Causes(changes=changes, operator=operator, links=drawn))
        shown = f"{CLOSED_LOOP}: {operator}" if operator else OPEN_LOOP
        metadata = run_metadata(
            scenario_json=conditions.scenario.model_dump_json(),
            versions=versions(),
            driver="lockstep",
        )
        metadata[DRIVER_RECORD]["steps"] = self.log.identity.timing
        metadata[WHAT_IF_RECORD] = {
            "source": self.log.path.name,
            "source_digest": self.digest,
            "changes": dumps([change._asdict() for change in changes]),
            "operator": shown,
            "links": links,
        }
        with in_place_of(out, replace=True) as unfinished, LogWriter(unfinished, metadata) as writer:
            write = LockstepLog(writer)

            def observe(topic: Topic, header: Header, body: Message) -> None:
                write(topic, header, body)
                watch(topic, header, body)

            loop = rerun_loop(self.run, conditions, observe, compiled)
            number = sum(len(session.steps) for session in self.run.sessions["plant"])
            for done, _ in enumerate(loop.steps(), start=1):
                if progress is not None and done % REPORT_EVERY == 0:
                    progress(done, number)
        return WhatIf(
            source=str(self.log.path),
            source_digest=self.digest,
            changes=tuple(map(str, changes)),
            operator=shown,
            links=links,
            is_exact=watch.is_exact,
            exactness=Exactness(compared=watch.compared, identical=watch.identical, only_in_log=watch.only_in_log),
            first_difference=watch.first,
            first_motion=watch.first_motion,
            doubts=self.run.doubts,
        )


REPORT_EVERY: Final = 100
"""Steps between two reports of progress."""


def _links_in_words(conditions: Conditions, run: RecordedRun) -> str:
    if conditions.links == "drawn":
        return f"drawn anew, seed {conditions.seed}"
    return "same draws as in the log" if run.is_virtual else "as recorded, message by message"
