"""Deliveries of inputs by the bus to a plant that read them through an injected link, from the plant's states.

A link draws the delay of each message from its number, not from its time. With the delays known, the lead of an input
that a state reports fits one step of the plant in which the bus can have delivered it, and no other.
"""

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from passafe_protocol.link import Link
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import LinkEvent, PlantInput, PlantState
from passafe_protocol.topics import INPUT

from passafe_services.log.continuity import LoggedMessage
from passafe_services.tools.what_if.recorded_steps import ProcessSession
from passafe_services.tools.what_if.route import LoggedArrival, Place

CANDIDATES: Final = 4
"""Steps of the plant from the sending of an input on in which it may have been delivered."""


class _Candidate(NamedTuple):
    """An input that a state reports, with the steps that may have received it and its delay in the link."""

    number: int
    starts_ns: Sequence[int]
    delay_ns: int
    plant_ns: int  # plant time of its arrival


class _Report(NamedTuple):
    """Number of the newest input that a state reports, −1 before the first, and the longest transit time."""

    newest: int
    transit_ns: int


def delivered(
    inputs: Sequence[LoggedMessage[PlantInput]],
    places: Sequence[Place],
    states: Sequence[LoggedMessage[PlantState]],
    plant: ProcessSession,
    period_ns: int,
    settings: LinkSettings,
    events: Sequence[LinkEvent],
) -> Mapping[Place, LoggedArrival]:
    """Return when the bus delivered inputs to the plant, as far as it can be shown.

    Args:
        inputs: All inputs of the log.
        places: Their places.
        states: All states of the plant.
        plant: Steps of the plant.
        period_ns: Their period, ns.
        settings: Settings of its link, which never changed.
        events: Effects of links in the log.
    """
    order = sorted(range(len(inputs)), key=lambda k: inputs[k].header.sent_ns)
    delays = _delays_ns(len(inputs), settings)
    lost = [inputs[k].header.sequence for n, k in enumerate(order) if n not in delays]
    logged = [event.sequence for event in events if event.topic == INPUT.name and event.effect == "dropped"]
    if not delays or lost[: len(logged)] != logged:  # those sent last may not have entered the link any more
        return {}
    starts_ns = [step.started_ns for step in plant.steps]
    number_of = {(inputs[k].header.epoch, inputs[k].body.tick): n for n, k in enumerate(order)}
    found = [
        _Candidate(n, _after(starts_ns, inputs[order[n]].header.sent_ns), delays[n], plant_ns)
        for n, plant_ns in _reported(states, number_of, [inputs[k].body for k in order])
        if n in delays
    ]
    origins = Counter(start + each.delay_ns - each.plant_ns for each in found for start in each.starts_ns)
    if not origins:
        return {}
    [(origin_ns, _)] = origins.most_common(1)
    known = {
        each.number: start
        for each in found
        for start in each.starts_ns
        if start + each.delay_ns - each.plant_ns == origin_ns
    }
    reports = _reports(states, number_of, starts_ns)

    def fits(number: int, start_ns: int) -> int:
        """Return how well a delivery fits the state after the input's arrival.

        Returns:
            0 if that state reports no input so new, or no transit so long; 2 if its transit has just become that of
            the input, or of an older one that it repeats; 1 otherwise.
        """
        if number not in delays:
            return 1
        arrival_ns = start_ns + delays[number]
        step = bisect_left(starts_ns, arrival_ns)
        if step == len(reports):
            return 1
        newest, transit_ns = reports[step]
        longer_ns = transit_ns - (arrival_ns - origin_ns - inputs[order[number]].header.scheduled_ns)
        if newest < number or longer_ns < 0:
            return 0
        is_new = step > 0 and reports[step - 1].transit_ns != transit_ns
        return 2 if is_new and longer_ns % period_ns == 0 else 1

    at: dict[Place, LoggedArrival] = {}
    last_ns = 0
    for number, k in enumerate(order):
        candidates = [start for start in _after(starts_ns, inputs[k].header.sent_ns) if start >= last_ns]
        if not candidates:
            break
        last_ns = known.get(number) or max(candidates, key=lambda start: fits(number, start))
        at[places[k]] = LoggedArrival(last_ns)
    return at


def _delays_ns(count: int, settings: LinkSettings) -> dict[int, int]:
    """Return the delay of every message that a link does not lose, by number; none where delays depend on the time."""
    by_time = settings.rate_hz or settings.trace_s or settings.outages_s or settings.network or settings.delay_trace_s
    if by_time or not settings.reorder or settings.duplicate:
        return {}
    link: Link[int] = Link("filter-to-plant", settings)
    for number in range(count):
        link.put(0, number)
    return {number: at_ns for at_ns, number in link.pop_arrived(2**62)}


def _after(starts_ns: Sequence[int], sent_ns: int) -> Sequence[int]:
    first = bisect_left(starts_ns, sent_ns)
    return starts_ns[first : first + CANDIDATES]


def _reported(
    states: Sequence[LoggedMessage[PlantState]],
    number_of: Mapping[tuple[int, int], int],
    inputs: Sequence[PlantInput],
) -> Iterator[tuple[int, int]]:
    """Yield the number of every input that a state reports as the newest, and the plant time of its arrival, ns."""
    seen = (0, 0)
    for _, state in states:
        newest = (state.input_epoch, state.received_tick)
        if newest != seen and newest in number_of:
            number = number_of[newest]
            yield number, inputs[number].effective_plant_ns - state.input_lead_ns
        seen = newest


def _reports(
    states: Sequence[LoggedMessage[PlantState]], number_of: Mapping[tuple[int, int], int], starts_ns: Sequence[int]
) -> list[_Report]:
    """Return what the plant reported after each of its steps."""
    reports = [_Report(-1, 0)] * len(starts_ns)
    for header, state in states:
        number = number_of.get((state.input_epoch, state.received_tick), -1)
        reports[bisect_left(starts_ns, header.started_ns)] = _Report(number, state.input_transit_ns)
    return reports
