"""Arrivals of logged messages at their readers, as far as the log shows them."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

from passafe_protocol.messages import (
    EmergencyStop,
    FilterTick,
    Header,
    OperatorCommand,
    PlantInput,
    PlantState,
    StopClear,
)
from passafe_protocol.topics import COMMAND, STOP, TOPIC_OF_BODY, Topic

from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.recorded_steps import ProcessSession
from passafe_services.tools.what_if.route import LOST_NS, LoggedArrival, Place

USUAL_LATENCY_NS: Final = 200_000
"""Time that a message takes on the bus where the log does not show it, ns."""


class Arrivals(NamedTuple):
    """Arrivals of one topic's messages at one reader.

    Attributes:
        at: Arrivals by place, by the reader's clock.
        latency_ns: Least time from sending to arrival, ns.
    """

    at: Mapping[Place, LoggedArrival]
    latency_ns: int


def places(headers: Iterable[Header]) -> list[Place]:
    """Return the places of the messages of one topic, which are in order of their sender's sequence."""
    found: list[Place] = []
    step, number = (0, 0), 0
    for header in headers:
        number = number + 1 if step == (header.epoch, header.scheduled_ns) else 0
        step = (header.epoch, header.scheduled_ns)
        found.append(Place(header.epoch, header.scheduled_ns, number))
    return found


def at_the_filter(log: RunLog, topic: Topic, offset_ns: int) -> Arrivals:
    """Return the arrivals of commands or states at the filter: its ticks list them.

    A message that no tick lists never came, unless ticks are missing in the log: then it is not known.

    Args:
        log: The log.
        topic: Commands or states.
        offset_ns: Filter's clock minus the sender's, ns.
    """
    body = OperatorCommand if topic is COMMAND else PlantState
    came: dict[tuple[int, int], LoggedArrival] = {}
    for tick in log.of(FilterTick):
        for rank, each in enumerate(tick.body.consumed):
            if each.topic == topic.name:
                came.setdefault((each.epoch, each.sequence), LoggedArrival(each.received_ns, each.term, rank))
    is_whole = not log.counts[TOPIC_OF_BODY[FilterTick].name].gaps
    messages = log.of(body)
    at: dict[Place, LoggedArrival] = {}
    least_ns: int | None = None
    for place, (header, _) in zip(places(message.header for message in messages), messages, strict=True):
        arrival = came.get((header.epoch, header.sequence))
        if arrival is not None:
            at[place] = arrival
            took_ns = arrival.at_ns - header.sent_ns - offset_ns
            least_ns = took_ns if least_ns is None else min(took_ns, least_ns)
        elif is_whole:
            at[place] = LoggedArrival(LOST_NS)
    return Arrivals(at, USUAL_LATENCY_NS if least_ns is None else max(least_ns, 0))


def at_the_plant(log: RunLog, plants: Sequence[ProcessSession]) -> Arrivals:
    """Return the arrivals of inputs at the plant: the step of the first state that counts an input or a newer one.

    An input that no state counts came after the plant's last step or never, unless states are missing in the log: then
    it is not known.

    Args:
        log: The log.
        plants: Sessions of the plant.
    """
    inputs = log.of(PlantInput)
    of_tick: dict[int, dict[int, Place]] = {}
    for place, (header, body) in zip(places(each.header for each in inputs), inputs, strict=True):
        of_tick.setdefault(header.epoch, {})[body.tick] = place
    started_ns = {(s.epoch, step.scheduled_ns): step.started_ns for s in plants for step in s.steps}
    at: dict[Place, LoggedArrival] = {}
    seen: tuple[int, int] = (0, 0)  # session of the filter and its newest tick that came
    for header, state in log.of(PlantState):
        if state.input_epoch == 0 or (state.input_epoch, state.received_tick) == seen:
            continue
        first = seen[1] + 1 if seen[0] == state.input_epoch else 1
        ticks = of_tick.get(state.input_epoch, {})
        for tick in range(first, state.received_tick + 1):
            if tick in ticks:
                at[ticks[tick]] = LoggedArrival(started_ns[header.epoch, header.scheduled_ns])
        seen = (state.input_epoch, state.received_tick)
    if not log.counts[TOPIC_OF_BODY[PlantState].name].gaps:
        for sent in of_tick.values():
            at = {place: LoggedArrival(LOST_NS) for place in sent.values()} | at
    return Arrivals(at, USUAL_LATENCY_NS)


def stops_at_the_plant(log: RunLog, topic: Topic) -> Arrivals:
    """Return the arrivals of presses or clears at the plant: the step of the first state that shows their effect."""
    at: dict[Place, LoggedArrival] = {}
    if topic is STOP:
        shown: dict[int, int] = {}
        for header, state in log.of(PlantState):
            shown.setdefault(state.stop, header.started_ns)
        presses = log.of(EmergencyStop)
        for place, (_, press) in zip(places(each.header for each in presses), presses, strict=True):
            seen_ns = shown.pop(press.id, None)
            if seen_ns is not None:
                at[place] = LoggedArrival(seen_ns)
        return Arrivals(at, USUAL_LATENCY_NS)
    ended: dict[int, int] = {}
    stop = 0
    for header, state in log.of(PlantState):
        if stop and state.stop != stop:
            ended.setdefault(stop, header.started_ns)
        stop = state.stop
    clears = log.of(StopClear)
    for place, (header, clear) in zip(places(each.header for each in clears), clears, strict=True):
        seen_ns = ended.get(clear.stop)
        if seen_ns is not None and header.sent_ns <= seen_ns:
            at[place] = LoggedArrival(seen_ns)
    return Arrivals(at, USUAL_LATENCY_NS)


def clock_offset_ns(headers: Iterable[Header], consumed: Mapping[tuple[int, int], int]) -> int:
    """Return the filter's clock minus the sender's, ns, from the fastest message."""
    took = [
        consumed[header.epoch, header.sequence] - header.sent_ns
        for header in headers
        if (header.epoch, header.sequence) in consumed
    ]
    return min(took, default=0)
