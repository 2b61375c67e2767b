"""Replays a filter from the messages that it consumed, and compares every tick to the last bit."""

from dataclasses import dataclass, field
from itertools import islice, repeat
from typing import Final

import numpy as np
from passafe_protocol.field_difference import are_identical, field_differences
from passafe_protocol.messages import FilterTick, Header, Message, OperatorCommand, PlantState, Received
from passafe_protocol.topics import COMMAND, STATE, TICK, TOPIC_OF_BODY

from passafe_services.filter.build import CompiledFilter, filter_node
from passafe_services.filter.node import FilterNode
from passafe_services.filter.telemetry import TickRecord
from passafe_services.filter.unpredicted_node import UnpredictedFilterNode
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.column import same_rows, take
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_columns import RECORD
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.info import versions
from passafe_services.tools.replay.logged_ticks import TICK_COLUMNS, LoggedStep, LoggedTicks, MessageKey
from passafe_services.tools.replay.replayed_ticks import ReplayedTicks
from passafe_services.tools.review.run_identity import RunIdentity

WANTS: Final[Wants] = {COMMAND.name: (RECORD,), STATE.name: (RECORD,), TICK.name: TICK_COLUMNS}
"""What the filter consumed and what it decided."""

KEPT: Final = 100_000
"""Messages that are kept for a tick that consumes them: 20 s of the fastest loop, longer than any link delays."""

PATIENCE: Final = 200_000
"""Messages after which one that a tick needs counts as missing: longer than a pass holds back what follows a gap."""

NAMED: Final = 4
"""Fields of a difference that are named."""

TOGETHER: Final = 1024
"""Ticks that are compared together."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Replay:
    """Result of a replay.

    Attributes:
        ticks: Ticks compared.
        identical: Ticks whose message was the same to the last bit.
        first_difference: First tick that differs, with the first of its fields that do: the logged value and the
            replayed one; empty without one.
        missing: Missing messages, ticks or messages that they consumed; from the first one on nothing is compared.
            The last step of a killed filter, which no log contains, does not count.
        versions: What computed the log and computes the replay in different versions, by name: the log's and this one.
    """

    ticks: int
    identical: int
    first_difference: str
    missing: int
    versions: dict[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def exact(self) -> bool:
        """True if every tick was compared and is identical."""
        return self.ticks > 0 and self.identical == self.ticks and not self.missing


@dataclass(slots=True)
class _Session:
    """Session of the filter.

    Attributes:
        node: Its node.
        ticks: Its ticks.
        waited: Messages since its next step began to wait for one that it consumed.
        rows: Rows of ticks that have been replayed and not compared.
        records: The replayed ones.
    """

    node: FilterNode | UnpredictedFilterNode
    ticks: LoggedTicks = field(default_factory=LoggedTicks)
    waited: int = 0
    rows: list[int] = field(default_factory=list)
    records: list[TickRecord] = field(default_factory=list)


class FilterReplay:
    """Replay of a filter, slice by slice of a log, whatever the order of its publishers.

    Attributes:
        is_over: Whether a message is missing, so that no further tick can be compared.
    """

    def __init__(self, identity: RunIdentity) -> None:
        """Start without messages.

        Args:
            identity: Identity of the run.

        Raises:
            DesignError: This version cannot build the filter of the scenario.
        """
        self.is_over = False
        self._identity = identity
        self._model = PlantModel.of(identity.scenario)
        self._compiled = CompiledFilter.of(identity.scenario, self._model.robot)
        self._replayed = ReplayedTicks(self._compiled)
        self._sent: dict[MessageKey, tuple[Header, Message]] = {}
        self._sessions: dict[int, _Session] = {}
        self._ticks = self._identical = self._missing = 0
        self._first_difference = ""

    def take(self, part: LogSlice) -> None:
        """Take the next messages of the log: columns as in ``WANTS``."""
        added = self._keep(part)
        for block in part.blocks(TICK.name):
            clock_id = int(block.numbers("header.clock_id")[0])
            self._session(block.epoch, clock_id).ticks.add(block)
            added += len(block)
        for session in self._sessions.values():
            session.waited += added
            self._advance(session, is_over=False)
        for key in [*islice(self._sent, max(len(self._sent) - KEPT, 0))]:
            del self._sent[key]

    def end(self) -> Replay:
        """Compare what is left, and return the result."""
        for session in self._sessions.values():
            self._advance(session, is_over=True)
        return Replay(
            ticks=self._ticks,
            identical=self._identical,
            first_difference=self._first_difference,
            missing=self._missing,
            versions=_other_versions(self._identity.versions),
        )

    def _session(self, epoch: int, clock_id: int) -> _Session:
        session = self._sessions.get(epoch)
        if session is None:
            node = filter_node(
                self._identity.scenario,
                self._identity.driver,
                epoch,
                self._model,
                self._compiled,
                clock_id=clock_id,
            )
            session = self._sessions[epoch] = _Session(node)
        return session

    def _keep(self, part: LogSlice) -> int:
        """Keep what a filter may consume; return how many messages that are."""
        count = 0
        for body in (OperatorCommand, PlantState):
            name = TOPIC_OF_BODY[body].name
            for block in part.blocks(name):
                keys = zip(repeat(name), repeat(block.epoch), block.sequence.tolist())
                added = dict(zip(keys, block.objects(RECORD), strict=True))
                added.update((key, self._sent[key]) for key in added.keys() & self._sent.keys())  # the first one counts
                before = len(self._sent)
                self._sent.update(added)
                count += len(self._sent) - before
        return count

    def _advance(self, session: _Session, *, is_over: bool) -> None:
        """Replay the steps that are complete, and compare them; give up one that waited for too long."""
        sent = self._sent
        for step in () if self.is_over else session.ticks.steps(is_over=is_over):
            missing = step.missing
            if not missing:
                try:
                    inbox = [Received(*sent[key], received_ns, term) for key, received_ns, term in step.consumed]
                except KeyError:
                    missing = sum(key not in sent for key, _, _ in step.consumed)
                    if not is_over and session.waited < PATIENCE:
                        break
            if missing:
                self._missing, self.is_over = missing, True
                break
            session.waited = 0
            self._replay(session, step, inbox)
        self._compare(session)

    def _replay(self, session: _Session, step: LoggedStep, inbox: list[Received]) -> None:
        outgoing = session.node.step(step.scheduled_ns, inbox)
        records = [body for topic, body in outgoing if topic is TICK and isinstance(body, TickRecord)]
        if step.is_open:
            del records[len(step.rows) :]
        both = min(len(step.rows), len(records))
        session.rows += step.rows[:both]
        session.records += records[:both]
        if len(session.rows) >= TOGETHER:
            self._compare(session)
        if len(step.rows) != len(records):
            self._compare(session)
            self._ticks += max(len(step.rows), len(records)) - both
            if not self._first_difference and len(records) > both:
                self._first_difference = "the replay has a tick that the log does not contain"
            elif not self._first_difference:
                tick = session.ticks.message(step.rows[both]).tick
                self._first_difference = f"tick {tick}: missing in the replay"

    def _compare(self, session: _Session) -> None:
        """Compare the ticks that have been replayed: all at once, and only those that seem to differ one by one."""
        rows, records = session.rows, session.records
        if not records:
            return
        session.rows, session.records = [], []
        same, places = np.ones(len(rows), dtype=np.bool_), np.array(rows)
        for path, replayed in self._replayed.columns(records).items():
            same &= same_rows(take(session.ticks.columns[path], places), replayed)
        self._ticks += len(rows)
        self._identical += int(same.sum())
        for place in np.nonzero(~same)[0].tolist():
            logged, replayed_tick = session.ticks.message(rows[place]), records[place]()
            if are_identical(logged, replayed_tick):
                self._identical += 1
            elif not self._first_difference:
                self._first_difference = _difference(logged, replayed_tick)


def _difference(logged: FilterTick, replayed: FilterTick) -> str:
    found = field_differences(logged, replayed)
    more = f", and {len(found) - NAMED} more fields" if len(found) > NAMED else ""
    return f"tick {logged.tick}: " + ", ".join(map(str, found[:NAMED])) + more


def _other_versions(logged: dict[str, str]) -> dict[str, tuple[str, str]]:
    """Return the versions that differ from this build's; of a log without any, none is known to differ."""
    own = versions()
    return {name: (logged[name], own[name]) for name in own if logged.get(name, own[name]) != own[name]}
