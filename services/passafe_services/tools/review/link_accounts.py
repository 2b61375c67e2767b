"""Accounts for every message of every link from three sources: logged messages, link events and link states.

The log contains the messages sent, LinkEvents the effects on single messages, and the last LinkState of a link the
totals. For every link and session of its reader

    sent − lost on the bus + duplicated = delivered + dropped + in flight

must hold with sent counted in the log, dropped and duplicated counted among the events, and the rest from the state;
counts available from two sources must agree.
"""

from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Final, Self, TypeAlias

import numpy as np
from passafe_protocol.link_effect import CAUSES
from passafe_protocol.messages import LinkSource, LinkState
from passafe_protocol.topics import LINK_EVENT, LINK_STATE, LINKS
from pydantic import BaseModel, ConfigDict

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.column import Texts
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_columns import RECORD
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.link_states import END, LinkStateCheck, count_differences, start_settings
from passafe_services.tools.review.run_log import RunLog

LinkSession: TypeAlias = tuple[str, str, int | None]
"""Link, process that reads it, and its session; ``None`` in lockstep, where a link outlives its reader's sessions."""


NO_MESSAGE: Final = -1
"""Number of a message of another topic than the link's: nobody sent it through the link."""


class LinkAccount(BaseModel):
    """Account of one link in one session of its reader, up to its last LinkState.

    Attributes:
        link: Name of the link.
        reader: Process that reads it.
        epoch: Session of the reader; ``None`` in lockstep, where a link outlives it.
        final: Whether the state is the one at the end; otherwise the reader was killed, and later messages are missing.
        sent: Messages from the first to the newest that the reader received of each session of a sender, by sequence
            number; the log must contain them all.
        lost_on_bus: Sent messages that never reached the reader.
        entered: Messages that entered the link.
        duplicated: Copies made.
        corrupted: Messages and copies with a flipped bit, delivered or in flight.
        delivered: Messages and copies that left the link.
        dropped: Messages dropped, by cause.
        in_flight: Messages and copies still in the link.
        refused_corrupted: Delivered messages that the decoder refused.
        refused_duplicate: Delivered messages refused as duplicates.
        differences: Differences between the counts of two sources, by kind; empty if all agree.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    link: str
    reader: str
    epoch: int | None
    final: bool
    sent: int
    lost_on_bus: int
    entered: int
    duplicated: int
    corrupted: int
    delivered: int
    dropped: dict[str, int]
    in_flight: int
    refused_corrupted: int
    refused_duplicate: int
    differences: dict[str, int]

    @property
    def text(self) -> str:
        """Account in one line."""
        causes = ", ".join(f"{cause} {number}" for cause, number in self.dropped.items() if number)
        dropped = f"{sum(self.dropped.values())} dropped" + (f" ({causes})" if causes else "")
        differences = "".join(f"; differs in {what} by {number}" for what, number in self.differences.items())
        return (
            f"{self.link}: {self.sent} sent − {self.lost_on_bus} lost on the bus + {self.duplicated} copies = "
            f"{self.delivered} delivered + {dropped} + {self.in_flight} in flight{differences}"
        )

    @classmethod
    def of(
        cls,
        key: LinkSession,
        state: LinkState,
        events: "EventCounts",
        sent: "SentNumbers",
        contradictions: Mapping[str, int],
    ) -> Self:
        """Return the account of one link.

        Args:
            key: Link, reader and session.
            state: Its last state.
            events: Its events up to that state.
            sent: Messages of the link's topic in the log.
            contradictions: What its states say and cannot be, by kind.
        """
        logged = sum(sent.count(source) for source in state.sources)
        offered = sum(_span(source) for source in state.sources)
        lost_on_bus = offered - sum(source.received for source in state.sources)
        dropped = dict(zip(CAUSES, (state.dropped_loss, state.dropped_queue, state.dropped_outage), strict=True))
        accounted = state.delivered + sum(dropped.values()) + state.in_flight
        compared = {
            "messages missing in the log": offered - logged,
            "events missing in the log": events.missing,
            "events of messages that were not sent": events.not_offered(state),
            "entered and sent": abs(offered - lost_on_bus - state.entered),
            "balance": abs(offered - lost_on_bus + state.duplicated - accounted),
            **count_differences(state, dropped, events.counts),
            **contradictions,
            "state at the end": int(key[2] is None and state.trigger != END),
        }
        return cls(
            link=key[0],
            reader=key[1],
            epoch=key[2],
            final=state.trigger == "end",
            sent=offered,
            lost_on_bus=lost_on_bus,
            entered=state.entered,
            duplicated=state.duplicated,
            corrupted=state.corrupted,
            delivered=state.delivered,
            dropped=dropped,
            in_flight=state.in_flight,
            refused_corrupted=state.refused_corrupted,
            refused_duplicate=state.refused_duplicate,
            differences={what: number for what, number in compared.items() if number},
        )


def link_accounts(log: RunLog) -> list[LinkAccount]:
    """Return the account of every link with a state in the log, in the order of the topic table, then by session."""
    record = LinkRecord(log.identity.scenario, is_live=log.identity.driver == "live")
    for part in log.slices(LinkRecord.wants):
        record.take(part)
    return record.accounts()


class SentNumbers:
    """Sequence numbers of the messages of one topic in a log, by sender and session, as ranges."""

    def __init__(self) -> None:
        self._ranges: dict[tuple[str, int], list[tuple[int, int]]] = {}

    def add(self, block: MessageBlock) -> None:
        """Add messages, in order of sequence."""
        sequence = block.sequence
        ranges = self._ranges.setdefault((block.source, block.epoch), [])
        ends = np.flatnonzero(np.diff(sequence) != 1).tolist()
        for begin, end in zip([0, *(row + 1 for row in ends)], [*ends, len(sequence) - 1], strict=True):
            first, last = int(sequence[begin]), int(sequence[end])
            if ranges and ranges[-1][1] + 1 == first:
                first = ranges.pop()[0]
            ranges.append((first, last))

    def count(self, source: LinkSource) -> int:
        """Return how many messages of a session of a sender, from its first to its newest, are in the log."""
        ranges = self._ranges.get((source.source, source.epoch), ())
        return sum(max(min(last, source.newest) - max(first, source.first) + 1, 0) for first, last in ranges)


@dataclass(kw_only=True)
class EventCounts:
    """Events of one link, up to the last state of the link.

    Attributes:
        counts: Number of events by effect and cause.
        missing: Events of the link's reader that are missing in the log up to the last of them.
        wanted: Events that the last state accounts for.
        strange: Numbers of messages that no sender had sent by the state after the event.
        waiting: Later events: effect, cause, number of the message, and how many of the reader's were missing.
    """

    counts: Counter[tuple[str, str]] = field(default_factory=Counter)
    missing: int = 0
    wanted: int = 0
    strange: list[int] = field(default_factory=list)
    waiting: deque[tuple[str, str, int, int]] = field(default_factory=deque)

    def settle(self, state: LinkState | None) -> None:
        """Count the waiting events that the last state accounts for."""
        if state is None:
            return
        self.wanted = (
            state.dropped_loss + state.dropped_queue + state.dropped_outage + state.duplicated + state.corrupted
        )
        while self.waiting and self.counts.total() < self.wanted:
            effect, cause, sequence, self.missing = self.waiting.popleft()
            self.counts[effect, cause] += 1
            if not _is_offered(sequence, state):
                self.strange.append(sequence)

    def not_offered(self, state: LinkState) -> int:
        """Return the number of events of messages that nobody sent."""
        return sum(not _is_offered(sequence, state) for sequence in self.strange)


class LinkRecord:
    """Accounts of the links of a run, as its messages come.

    Args:
        scenario: The scenario.
        is_live: Whether each reader has a session of its own; in lockstep, a link outlives it.
    """

    wants: ClassVar[Wants] = {
        LINK_STATE.name: (RECORD,),
        LINK_EVENT.name: ("link", "effect", "cause", "topic", "sequence"),
        **{place.topic.name: () for place in LINKS.values()},
    }

    def __init__(self, scenario: Scenario, *, is_live: bool) -> None:
        self._is_live = is_live
        self._starts = start_settings(scenario)
        self._checks: dict[LinkSession, LinkStateCheck] = {}
        self._last: dict[LinkSession, LinkState] = {}
        self._events: dict[LinkSession, EventCounts] = {}
        self._missing: dict[tuple[str, int | None], int] = {}
        self._expected: dict[tuple[str, int], int] = {}
        self._sent: dict[str, SentNumbers] = {place.topic.name: SentNumbers() for place in LINKS.values()}

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for name, sent in self._sent.items():
            for block in part.blocks(name):
                sent.add(block)
        for block in part.blocks(LINK_EVENT.name):
            self._take_events(block)
        for block in part.blocks(LINK_STATE.name):
            for _, state in block.objects(RECORD):
                key = self._key(state.link, block)
                self._last[key] = state
                if key not in self._checks:
                    self._checks[key] = LinkStateCheck(state.link, self._starts.get(state.link))
                self._checks[key].take(state, block.epoch)
        for session, events in self._events.items():
            events.settle(self._last.get(session))

    def accounts(self) -> list[LinkAccount]:
        """Return the account of every link with a state, in the order of the topic table, then by session."""
        found = []
        for name, place in LINKS.items():
            for key, state in self._last.items():
                if key[0] == name:
                    events = self._events.get(key, EventCounts())
                    events.settle(state)
                    if events.counts.total() < events.wanted:  # all of the reader's were looked through
                        events.missing = self._missing.get(key[1:], 0)
                    found.append(
                        LinkAccount.of(key, state, events, self._sent[place.topic.name], self._checks[key].found)
                    )
        return found

    def _take_events(self, block: MessageBlock) -> None:
        links, effects, causes, topics = (_words(block.texts(path)) for path in ("link", "effect", "cause", "topic"))
        session = (block.source, block.epoch)
        reader = (block.source, block.epoch if self._is_live else None)
        numbers, messages = block.sequence.tolist(), block.numbers("sequence").astype(np.int64)
        messages[[topic != LINKS[link].topic.name for link, topic in zip(links, topics, strict=True)]] = NO_MESSAGE
        for number, link, effect, cause, message in zip(
            numbers, links, effects, causes, messages.tolist(), strict=True
        ):
            missing = self._missing.get(reader, 0) + number - self._expected.get(session, 0)
            self._missing[reader], self._expected[session] = missing, number + 1
            events = self._events.setdefault(self._key(link, block), EventCounts())
            events.waiting.append((effect, cause, message, missing))

    def _key(self, link: str, block: MessageBlock) -> LinkSession:
        return link, block.source, block.epoch if self._is_live else None


def _words(texts: Texts) -> list[str]:
    if not isinstance(texts.codes, np.ndarray):
        raise TypeError("texts: got lists, allowed one a message")
    return [texts.words[code] for code in texts.codes.tolist()]


def _span(source: LinkSource) -> int:
    return source.newest - source.first + 1


def _is_offered(sequence: int, state: LinkState) -> bool:
    return any(source.first <= sequence <= source.newest for source in state.sources)
