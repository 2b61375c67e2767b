"""Whether every message of every link is accounted for, from three sources: the log, the events and the states.

The log tells what was sent, LinkEvents what was done to single messages, and the last LinkState of a link what became
of all of them. For every link and session of its reader

    sent − lost on the bus + duplicated = delivered + dropped + under way

must hold with the sent ones counted in the log, those dropped and duplicated counted among the events, and the rest
from the state; and what two of the three tell must be the same.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Self, TypeAlias

from passafe_protocol.link_effect import CAUSES
from passafe_protocol.messages import LinkEvent, LinkSource, LinkState, Message
from passafe_protocol.topics import LINKS, Topic
from pydantic import BaseModel, ConfigDict

from passafe_services.tools.review.continuity import LoggedMessage
from passafe_services.tools.review.run_log import RunLog

Reader: TypeAlias = tuple[str, str, int | None]
"""Link, process that reads it, and its session; ``None`` in lockstep, where a link outlives its reader's sessions."""

Sent: TypeAlias = dict[tuple[str, int], set[int]]
"""Numbers of the messages in the log, by sender and session."""


class LinkAccount(BaseModel):
    """What became of the messages of one link, in one session of the process that reads it, up to its last LinkState.

    Attributes:
        link: Name of the link.
        reader: Process at whose inlet it sits.
        epoch: Its session; ``None`` in lockstep, where a link outlives it.
        final: The state is the one of the end; otherwise the reader was killed, and what came later is not counted.
        sent: Messages from the first to the newest that the reader had of each session of a sender, by their numbers;
            the log must hold them all.
        lost_on_bus: Of them, those that never reached the reader.
        entered: Messages that entered the link.
        duplicated: Copies that it made.
        corrupted: Messages and copies with a bit flipped; delivered or under way like others.
        delivered: Messages and copies that came out.
        dropped: Messages that never did, by cause.
        in_flight: Messages and copies not come out yet.
        refused_corrupted: Of those delivered, those that the decoder refused.
        refused_duplicate: Of those delivered, those that the reader had before.
        differences: Messages that two sources tell differently, by what they differ in; empty if all is exact.
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
        """The account in one line."""
        causes = ", ".join(f"{cause} {number}" for cause, number in self.dropped.items() if number)
        dropped = f"{sum(self.dropped.values())} dropped" + (f" ({causes})" if causes else "")
        told = "".join(f"; differs in {what} by {number}" for what, number in self.differences.items())
        return (
            f"{self.link}: {self.sent} sent − {self.lost_on_bus} lost on the bus + {self.duplicated} copies = "
            f"{self.delivered} delivered + {dropped} + {self.in_flight} under way{told}"
        )

    @classmethod
    def of(cls, key: Reader, state: LinkState, events: Sequence[LoggedMessage[LinkEvent]], sent: Sent) -> Self:
        """Make the account of one link.

        Args:
            key: Which link and reader.
            state: Its last state.
            events: All LinkEvents of that process and session, of all its links, in order.
            sent: Messages of the link's topic in the log.
        """
        logged = sum(len(_in_window(source, sent)) for source in state.sources)
        offered = sum(_span(source) for source in state.sources)
        lost_on_bus = offered - sum(source.received for source in state.sources)
        dropped = dict(zip(CAUSES, (state.dropped_loss, state.dropped_queue, state.dropped_outage), strict=True))
        told, untold = _told(state, events)
        came_out = state.delivered + sum(dropped.values()) + state.in_flight
        compared = {
            "messages missing in the log": offered - logged,
            "events missing in the log": untold,
            "events of messages that were not sent": sum(not _is_offered(event, state) for event in told),
            "entered and sent": abs(offered - lost_on_bus - state.entered),
            "balance": abs(offered - lost_on_bus + state.duplicated - came_out),
            **_compared(state, dropped, told),
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
    """Accounts of every link that the log tells a state of, in the order of the topic table, then by session."""
    last: dict[Reader, LinkState] = {}
    for told in log.of(LinkState):
        last[_key(log, told.body.link, told)] = told.body
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


def _key(log: RunLog, link: str, told: LoggedMessage[LinkState] | LoggedMessage[LinkEvent]) -> Reader:
    return link, told.header.source, told.header.epoch if log.identity.driver == "live" else None


def _sent(log: RunLog, topic: Topic) -> Sent:
    numbers: Sent = {}
    messages: Iterable[LoggedMessage[Message]] = log.messages.get(topic.name, ())
    for header, _ in messages:
        numbers.setdefault((header.source, header.epoch), set()).add(header.sequence)
    return numbers


def _in_window(source: LinkSource, sent: Sent) -> set[int]:
    """Of the messages in the log, those that the reader can have had of one session of a sender."""
    numbers = sent.get((source.source, source.epoch), set())
    return {number for number in numbers if source.first <= number <= source.newest}


def _span(source: LinkSource) -> int:
    return source.newest - source.first + 1


def _is_offered(event: LinkEvent, state: LinkState) -> bool:
    return any(source.first <= event.sequence <= source.newest for source in state.sources)


def _told(state: LinkState, events: Sequence[LoggedMessage[LinkEvent]]) -> tuple[list[LinkEvent], int]:
    """The link's events up to its state, and how many are missing in the log up to the last of them."""
    wanted = state.dropped_loss + state.dropped_queue + state.dropped_outage + state.duplicated + state.corrupted
    told: list[LinkEvent] = []
    missing = 0
    expected: dict[int, int] = {}  # next number, by session
    for header, event in events:
        if len(told) == wanted:
            break
        missing += header.sequence - expected.get(header.epoch, 0)
        expected[header.epoch] = header.sequence + 1
        if event.link == state.link:
            told.append(event)
    return told, missing


def _compared(state: LinkState, dropped: dict[str, int], told: Sequence[LinkEvent]) -> dict[str, int]:
    """By how much the counts of the state differ from those of the events."""
    counts = Counter((event.effect, event.cause) for event in told)
    differences = {
        f"dropped by {cause}": abs(number - counts.pop(("dropped", cause), 0)) for cause, number in dropped.items()
    }
    differences["duplicated"] = abs(state.duplicated - counts.pop(("duplicated", ""), 0))
    differences["corrupted"] = abs(state.corrupted - counts.pop(("corrupted", ""), 0))
    differences["events of no known effect"] = sum(counts.values())
    return differences
