"""Replays a filter from the messages that it consumed, and compares every tick to the last bit."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import Final, TypeAlias

from passafe_protocol.field_difference import are_identical, field_differences
from passafe_protocol.messages import FilterTick, Header, Message, OperatorCommand, PlantState, Received, Record
from passafe_protocol.topics import TICK, TOPIC_OF_BODY

from passafe_services.filter.build import CompiledFilter, filter_node
from passafe_services.filter.node import FilterNode
from passafe_services.filter.unpredicted_node import UnpredictedFilterNode
from passafe_services.log.continuity import LoggedMessage
from passafe_services.plant_contract.plant_model import PlantModel
from passafe_services.scenarios.info import versions
from passafe_services.tools.review.run_identity import RunIdentity

KEPT: Final = 100_000
"""Messages that are kept for a tick that consumes them: 20 s of the fastest loop, longer than any link delays."""

PATIENCE: Final = 20_000
"""Messages after which one that a tick needs counts as missing: publishers are logged in no order."""

NAMED: Final = 4
"""Fields of a difference that are named."""

_Key: TypeAlias = tuple[str, int, int]
"""Topic, session and number of a message."""


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
    """Session of the filter: its node, the number of its next tick, and the ticks that are not compared yet."""

    node: FilterNode | UnpredictedFilterNode
    expected: int = 0
    waited: int = 0
    ticks: dict[int, LoggedMessage[FilterTick]] = field(default_factory=dict)

    def whole_step(self) -> list[LoggedMessage[FilterTick]]:
        """Return the ticks of the next step; none while another one of it may come."""
        found: list[LoggedMessage[FilterTick]] = []
        while (tick := self.ticks.get(self.expected + len(found))) is not None:
            if found and tick.header.scheduled_ns != found[0].header.scheduled_ns:
                return found
            found.append(tick)
        return []

    def rest_of_step(self) -> list[LoggedMessage[FilterTick]]:
        """Return the ticks of the next step that there are."""
        ordered = [self.ticks[number] for number in sorted(self.ticks)]
        return [tick for tick in ordered if tick.header.scheduled_ns == ordered[0].header.scheduled_ns]


class FilterReplay:
    """Replay of a filter, message by message, in any order that a recorder may log.

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
        self._sent: dict[_Key, LoggedMessage[Message]] = {}
        self._order: deque[_Key] = deque()
        self._sessions: dict[int, _Session] = {}
        self._ticks = self._identical = self._missing = 0
        self._first_difference = ""

    def add(self, header: Header, body: Message) -> None:
        """Add a message of the log; those that a replay does not need are ignored."""
        if self.is_over:
            return
        if isinstance(body, FilterTick):
            self._session(header).ticks.setdefault(header.sequence, LoggedMessage(header, body))
        elif isinstance(body, OperatorCommand | PlantState):
            self._keep(header, body)
        for session in self._sessions.values():
            self._advance(session)

    def end(self) -> Replay:
        """Compare what is left, and return the result."""
        for session in self._sessions.values():
            while session.ticks and not self.is_over:
                step = session.rest_of_step()
                self._compare(session, step, is_last=len(step) == len(session.ticks))
        return Replay(
            ticks=self._ticks,
            identical=self._identical,
            first_difference=self._first_difference,
            missing=self._missing,
            versions=_other_versions(self._identity.versions),
        )

    def _session(self, header: Header) -> _Session:
        session = self._sessions.get(header.epoch)
        if session is None:
            node = filter_node(
                self._identity.scenario,
                self._identity.driver,
                header.epoch,
                self._model,
                self._compiled,
                clock_id=header.clock_id,
            )
            session = self._sessions[header.epoch] = _Session(node)
        return session

    def _keep(self, header: Header, body: Message) -> None:
        key = (TOPIC_OF_BODY[type(body)].name, header.epoch, header.sequence)
        if key in self._sent:
            return
        self._sent[key] = LoggedMessage(header, body)
        self._order.append(key)
        if len(self._order) > KEPT:
            del self._sent[self._order.popleft()]

    def _advance(self, session: _Session) -> None:
        """Compare the steps that are complete; give up one that waited for too long."""
        while session.ticks and not self.is_over:
            step = session.whole_step()
            if not step or any(key not in self._sent for key in _keys(step)):
                session.waited += 1
                if session.waited < PATIENCE or (not step and len(session.ticks) == len(session.rest_of_step())):
                    return
                step = session.rest_of_step()
            session.waited = 0
            self._compare(session, step, is_last=False)

    def _compare(self, session: _Session, step: Sequence[LoggedMessage[FilterTick]], *, is_last: bool) -> None:
        keys, newest = _keys(step), step[-1].header.sequence
        self._missing = newest + 1 - session.expected - len(step) + sum(key not in self._sent for key in keys)
        if self._missing:
            self.is_over = True
            return
        session.expected = newest + 1
        for tick in step:
            del session.ticks[tick.header.sequence]
        consumed = [each for tick in step for each in tick.body.consumed]
        sent = [self._sent[key] for key in keys]
        inbox = [
            Received(header, body, each.received_ns, each.term)
            for (header, body), each in zip(sent, consumed, strict=True)
        ]
        outgoing = session.node.step(step[0].header.scheduled_ns, inbox)
        replayed = [body if isinstance(body, Record) else body() for topic, body in outgoing if topic is TICK]
        if is_last:
            del replayed[len(step) :]
        for logged, again in zip_longest(step, replayed):
            self._ticks += 1
            if logged is not None and again is not None and are_identical(logged.body, again):
                self._identical += 1
            elif not self._first_difference:
                self._first_difference = _difference(logged, again)


def _keys(step: Sequence[LoggedMessage[FilterTick]]) -> list[_Key]:
    return [(each.topic, each.epoch, each.sequence) for tick in step for each in tick.body.consumed]


def _difference(logged: LoggedMessage[FilterTick] | None, replayed: Message | None) -> str:
    if logged is None:
        return "the replay has a tick that the log does not contain"
    number = f"tick {logged.body.tick}"
    if replayed is None:
        return f"{number}: missing in the replay"
    found = field_differences(logged.body, replayed)
    more = f", and {len(found) - NAMED} more fields" if len(found) > NAMED else ""
    return f"{number}: " + ", ".join(map(str, found[:NAMED])) + more


def _other_versions(logged: dict[str, str]) -> dict[str, tuple[str, str]]:
    """Return the versions that differ from this build's; of a log without any, none is known to differ."""
    own = versions()
    return {name: (logged[name], own[name]) for name in own if logged.get(name, own[name]) != own[name]}
