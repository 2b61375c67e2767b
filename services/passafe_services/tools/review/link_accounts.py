"""Accounts for every message of every link from three sources: logged messages, link events and link states.

The log contains the messages sent, LinkEvents the effects on single messages, and the last LinkState of a link the
totals. For every link and session of its reader

    sent − lost on the bus + duplicated = delivered + dropped + in flight

must hold with sent counted in the log, dropped and duplicated counted among the events, and the rest from the state;
counts available from two sources must agree.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Self, TypeAlias

from passafe_protocol.link_effect import CAUSES
from passafe_protocol.messages import LinkEvent, LinkSource, LinkState, Message
from passafe_protocol.topics import LINKS, Topic
from pydantic import BaseModel, ConfigDict

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.run_log import RunLog

LinkSession: TypeAlias = tuple[str, str, int | None]
"""Link, process that reads it, and its session; ``None`` in lockstep, where a link outlives its reader's sessions."""

SentNumbers: TypeAlias = dict[tuple[str, int], set[int]]
"""Sequence numbers of the messages in the log, by sender and session."""


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
        cls, key: LinkSession, state: LinkState, events: Sequence[LoggedMessage[LinkEvent]], sent: SentNumbers
    ) -> Self:
        """Return the account of one link.

        Args:
            key: Link, reader and session.
            state: Its last state.
            events: All LinkEvents of that process and session, of all its links, in order.
            sent: Messages of the link's topic in the log.
        """
        logged = sum(len(_in_window(source, sent)) for source in state.sources)
        offered = sum(_span(source) for source in state.sources)
        lost_on_bus = offered - sum(source.received for source in state.sources)
        dropped = dict(zip(CAUSES, (state.dropped_loss, state.dropped_queue, state.dropped_outage), strict=True))
        logged_events, missing_events = _events_until(state, events)
        accounted = state.delivered + sum(dropped.values()) + state.in_flight
        compared = {
            "messages missing in the log": offered - logged,
            "events missing in the log": missing_events,
            "events of messages that were not sent": sum(not _is_offered(event, state) for event in logged_events),
            "entered and sent": abs(offered - lost_on_bus - state.entered),
            "balance": abs(offered - lost_on_bus + state.duplicated - accounted),
            **_compared(state, dropped, logged_events),
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
    last: dict[LinkSession, LinkState] = {}
    for state in log.of(LinkState):
        last[_key(log, state.body.link, state)] = state.body
    events: dict[tuple[str, int | None], list[LoggedMessage[LinkEvent]]] = {}
    for event in log.of(LinkEvent):
        _, source, session = _key(log, event.body.link, event)
        events.setdefault((source, session), []).append(event)
    sent = {place.topic.name: _sent(log, place.topic) for place in LINKS.values()}
    return [
        LinkAccount.of(key, last[key], events.get(key[1:], ()), sent[LINKS[name].topic.name])
        for name in LINKS
        for key in last
        if key[0] == name
    ]


def _key(log: RunLog, link: str, message: LoggedMessage[LinkState] | LoggedMessage[LinkEvent]) -> LinkSession:
    return link, message.header.source, message.header.epoch if log.identity.driver == "live" else None


def _sent(log: RunLog, topic: Topic) -> SentNumbers:
    numbers: SentNumbers = {}
    messages: Iterable[LoggedMessage[Message]] = log.messages.get(topic.name, ())
    for header, _ in messages:
        numbers.setdefault((header.source, header.epoch), set()).add(header.sequence)
    return numbers


def _in_window(source: LinkSource, sent: SentNumbers) -> set[int]:
    """Return the logged messages of one session of a sender that the reader can have received."""
    numbers = sent.get((source.source, source.epoch), set())
    return {number for number in numbers if source.first <= number <= source.newest}


def _span(source: LinkSource) -> int:
    return source.newest - source.first + 1


def _is_offered(event: LinkEvent, state: LinkState) -> bool:
    return any(source.first <= event.sequence <= source.newest for source in state.sources)


def _events_until(state: LinkState, events: Sequence[LoggedMessage[LinkEvent]]) -> tuple[list[LinkEvent], int]:
    """Return the link's events up to its state, and the number of events missing in the log up to the last of them."""
    wanted = state.dropped_loss + state.dropped_queue + state.dropped_outage + state.duplicated + state.corrupted
    found: list[LinkEvent] = []
    missing = 0
    expected: dict[int, int] = {}  # next number, by session
    for header, event in events:
        if len(found) == wanted:
            break
        missing += header.sequence - expected.get(header.epoch, 0)
        expected[header.epoch] = header.sequence + 1
        if event.link == state.link:
            found.append(event)
    return found, missing


def _compared(state: LinkState, dropped: dict[str, int], events: Sequence[LinkEvent]) -> dict[str, int]:
    """Return the differences between the counts of the state and of the events."""
    counts = Counter((event.effect, event.cause) for event in events)
    differences = {
        f"dropped by {cause}": abs(number - counts.pop(("dropped", cause), 0)) for cause, number in dropped.items()
    }
    differences["duplicated"] = abs(state.duplicated - counts.pop(("duplicated", ""), 0))
    differences["corrupted"] = abs(state.corrupted - counts.pop(("corrupted", ""), 0))
    differences["events of no known effect"] = sum(counts.values())
    return differences
