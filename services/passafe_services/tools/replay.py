"""Steps the filter of a logged run again, from what it consumed, and compares every tick to the last bit."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, zip_longest

from passafe_protocol.messages import FilterTick, Message, OperatorCommand, PlantState, Received, Record
from passafe_protocol.shapes import shape_of
from passafe_protocol.topics import TICK, TOPIC_OF_BODY

from passafe_services.filter.build import filter_node
from passafe_services.tools.review.continuity import LoggedMessage
from passafe_services.tools.review.run_log import RunLog


@dataclass(frozen=True, kw_only=True, slots=True)
class Replay:
    """What a second stepping showed.

    Attributes:
        ticks: Ticks compared.
        identical: Of them, those whose message was the same to the last bit.
        first_difference: Number and field of the first tick that was not; empty if there is none.
        missing: Messages that the log does not hold, ticks or what they consumed; from the first of them on nothing
            is compared. What a filter that was killed did last is in no log, and is not missed.
    """

    ticks: int
    identical: int
    first_difference: str
    missing: int

    @property
    def exact(self) -> bool:
        """Whether every tick was compared and found the same."""
        return self.ticks > 0 and self.identical == self.ticks and not self.missing


def replay_filter(log: RunLog) -> Replay:
    """Step the filter of a run again.

    Returns:
        How far the second stepping agrees with the log.
    """
    sent = dict(_consumable(log))
    ticks = identical = missing = 0
    first_difference = ""
    for epoch, found in groupby(log.of(FilterTick), key=lambda logged: logged.header.epoch):
        node = filter_node(log.identity.scenario, log.identity.driver, epoch)
        session = list(found)
        expected, last = 0, session[-1]
        # A step that made several inputs tells of each.
        for due_ns, step in groupby(session, key=lambda logged: logged.header.scheduled_ns):
            told = list(step)
            consumed = [each for logged in told for each in logged.body.consumed]
            keys = [(each.topic, each.epoch, each.sequence) for each in consumed]
            missing = told[-1].header.sequence + 1 - expected - len(told) + sum(key not in sent for key in keys)
            expected = told[-1].header.sequence + 1
            if missing:
                return Replay(ticks=ticks, identical=identical, first_difference=first_difference, missing=missing)
            inbox = [
                Received(sent[key].header, sent[key].body, each.received_ns)
                for key, each in zip(keys, consumed, strict=True)
            ]
            again = [
                body if isinstance(body, Record) else body()
                for topic, body in node.step(due_ns, inbox)
                if topic is TICK
            ]
            if told[-1] is last:
                del again[len(told) :]
            for logged, made in zip_longest(told, again):
                ticks += 1
                if logged is not None and made == logged.body:
                    identical += 1
                elif not first_difference:
                    first_difference = _difference(logged, made)
    return Replay(ticks=ticks, identical=identical, first_difference=first_difference, missing=missing)


def _consumable(log: RunLog) -> Iterator[tuple[tuple[str, int, int], LoggedMessage[Message]]]:
    for body_type in (OperatorCommand, PlantState):
        topic = TOPIC_OF_BODY[body_type].name
        for logged in log.of(body_type):
            yield (topic, logged.header.epoch, logged.header.sequence), logged


def _difference(logged: LoggedMessage[FilterTick] | None, again: Message | None) -> str:
    if logged is None:
        return "a tick came out that the log does not hold"
    number = f"tick {logged.body.tick}"
    if not isinstance(again, FilterTick):
        return f"{number}: no tick came out"
    shape = shape_of(FilterTick)
    pairs = zip(shape.names, shape.read(logged.body), shape.read(again), strict=True)
    return f"{number}: " + ", ".join(field for field, before, after in pairs if before != after)
