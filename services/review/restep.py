"""Steps the filter of a logged run again, from what it consumed, and compares every tick to the last bit."""

from collections.abc import Iterator
from dataclasses import dataclass

from msgspec.structs import astuple

from protocol.messages import FilterTick, Message, OperatorCommand, PlantState, Received
from protocol.topics import TICK, TOPIC_OF_BODY
from services.assembly import filter_node
from services.review.continuity import Logged
from services.review.log import RunLog


@dataclass(frozen=True, kw_only=True, slots=True)
class Restep:
    """What a second stepping showed.

    Attributes:
        ticks: Ticks compared.
        identical: Of them, those whose message was the same to the last bit.
        first_difference: Number and field of the first tick that was not; empty if there is none.
        missing: Consumed messages that the log does not hold; from the first of them on nothing is compared.
    """

    ticks: int
    identical: int
    first_difference: str
    missing: int

    @property
    def exact(self) -> bool:
        """Whether every tick was compared and found the same."""
        return self.ticks > 0 and self.identical == self.ticks and not self.missing


def restep(log: RunLog) -> Restep:
    """Step the filter of a run again.

    Returns:
        How far the second stepping agrees with the log.
    """
    node = filter_node(log.identity.scenario, log.identity.driver)
    sent = dict(_consumable(log))
    ticks = identical = missing = 0
    first_difference = ""
    for logged in log.of(FilterTick):
        keys = [(c.topic, c.epoch, c.sequence) for c in logged.body.consumed]
        missing = sum(key not in sent for key in keys)
        if missing:
            break
        inbox = [
            Received(sent[key].header, sent[key].body, consumed.received_ns)
            for key, consumed in zip(keys, logged.body.consumed, strict=True)
        ]
        again = None
        for topic, made in node.step(logged.header.scheduled_ns, inbox):
            if topic is TICK:
                again = made() if callable(made) else made
        ticks += 1
        if again == logged.body:
            identical += 1
        elif not first_difference:
            first_difference = f"tick {logged.body.tick}: {_differing_fields(logged.body, again)}"
    return Restep(ticks=ticks, identical=identical, first_difference=first_difference, missing=missing)


def _consumable(log: RunLog) -> Iterator[tuple[tuple[str, int, int], Logged[Message]]]:
    for body_type in (OperatorCommand, PlantState):
        topic = TOPIC_OF_BODY[body_type].name
        for logged in log.of(body_type):
            yield (topic, logged.header.epoch, logged.header.sequence), logged


def _differing_fields(logged: FilterTick, again: Message | None) -> str:
    if not isinstance(again, FilterTick):
        return "no tick came out"
    pairs = zip(logged.__struct_fields__, astuple(logged), astuple(again), strict=True)
    return ", ".join(field for field, before, after in pairs if before != after)
