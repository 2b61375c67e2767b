"""Replays the filter of a logged run from the messages that it consumed, and compares every tick to the last bit."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby, zip_longest

from passafe_protocol.messages import FilterTick, Message, OperatorCommand, PlantState, Received, Record
from passafe_protocol.shapes import shape_of
from passafe_protocol.topics import TICK, TOPIC_OF_BODY

from passafe_services.filter.build import filter_node
from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.review.run_log import RunLog


@dataclass(frozen=True, kw_only=True, slots=True)
class Replay:
    """Result of a replay.

    Attributes:
        ticks: Ticks compared.
        identical: Ticks whose message was the same to the last bit.
        first_difference: Number and fields of the first tick that differs; empty without one.
        missing: Missing messages, ticks or messages that they consumed; from the first one on nothing is compared.
            The last step of a killed filter, which no log contains, does not count.
    """

    ticks: int
    identical: int
    first_difference: str
    missing: int

    @property
    def exact(self) -> bool:
        """True if every tick was compared and is identical."""
        return self.ticks > 0 and self.identical == self.ticks and not self.missing


def replay_filter(log: RunLog) -> Replay:
    """Replay the filter of a run.

    Returns:
        Agreement of the replay with the log.
    """
    sent = dict(_consumable(log))
    ticks = identical = missing = 0
    first_difference = ""
    for epoch, found in groupby(log.of(FilterTick), key=lambda logged: logged.header.epoch):
        session = list(found)
        clock_id = session[0].header.clock_id
        node = filter_node(log.identity.scenario, log.identity.driver, epoch, clock_id=clock_id)
        expected, last = 0, session[-1]
        # A step with several inputs has a tick for each.
        for due_ns, step in groupby(session, key=lambda logged: logged.header.scheduled_ns):
            logged_ticks = list(step)
            consumed = [each for logged in logged_ticks for each in logged.body.consumed]
            keys = [(each.topic, each.epoch, each.sequence) for each in consumed]
            newest = logged_ticks[-1].header.sequence
            missing = newest + 1 - expected - len(logged_ticks) + sum(key not in sent for key in keys)
            expected = newest + 1
            if missing:
                return Replay(ticks=ticks, identical=identical, first_difference=first_difference, missing=missing)
            inbox = [
                Received(sent[key].header, sent[key].body, each.received_ns, each.term)
                for key, each in zip(keys, consumed, strict=True)
            ]
            replayed = [
                body if isinstance(body, Record) else body()
                for topic, body in node.step(due_ns, inbox)
                if topic is TICK
            ]
            if logged_ticks[-1] is last:
                del replayed[len(logged_ticks) :]
            for logged, body in zip_longest(logged_ticks, replayed):
                ticks += 1
                if logged is not None and body == logged.body:
                    identical += 1
                elif not first_difference:
                    first_difference = _difference(logged, body)
    return Replay(ticks=ticks, identical=identical, first_difference=first_difference, missing=missing)


def _consumable(log: RunLog) -> Iterator[tuple[tuple[str, int, int], LoggedMessage[Message]]]:
    for body_type in (OperatorCommand, PlantState):
        topic = TOPIC_OF_BODY[body_type].name
        for logged in log.of(body_type):
            yield (topic, logged.header.epoch, logged.header.sequence), logged


def _difference(logged: LoggedMessage[FilterTick] | None, replayed: Message | None) -> str:
    if logged is None:
        return "the replay has a tick that the log does not contain"
    number = f"tick {logged.body.tick}"
    if not isinstance(replayed, FilterTick):
        return f"{number}: missing in the replay"
    shape = shape_of(FilterTick)
    pairs = zip(shape.names, shape.read(logged.body), shape.read(replayed), strict=True)
    return f"{number}: " + ", ".join(field for field, before, after in pairs if before != after)
