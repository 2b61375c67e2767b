"""A logged run as a re-run needs it: steps, arrivals, and the messages of people."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from passafe_protocol.messages import (
    EmergencyStop,
    FilterTick,
    LinkConfig,
    LinkEvent,
    Message,
    OperatorCommand,
    PlantInput,
    PlantState,
    StopClear,
)
from passafe_protocol.topics import CLEAR, COMMAND, INPUT, STATE, STOP, TOPIC_OF_BODY, Topic

from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.arrivals import (
    USUAL_LATENCY_NS,
    Arrivals,
    at_the_filter,
    at_the_plant,
    clock_offset_ns,
    places,
    stops_at_the_plant,
)
from passafe_services.tools.what_if.bus_arrivals import delivered
from passafe_services.tools.what_if.errors import RerunError
from passafe_services.tools.what_if.recorded_steps import FILTER, OPERATOR, PLANT, ProcessSession, Step, sessions_of
from passafe_services.tools.what_if.rerun_loop import Resent

RESENT: Final = (OperatorCommand, EmergencyStop, StopClear, LinkConfig)
"""Messages of people: sent again as they were."""


@dataclass(frozen=True, kw_only=True)
class RecordedRun:
    """A logged run as a re-run needs it.

    Attributes:
        path: The log.
        scenario: Its scenario.
        is_virtual: Whether its steps are those of virtual time: not of a live run, nor of a re-run of one.
        sessions: Sessions of every process, by its name; of the operator, its first one.
        offsets_ns: Clock of the filter minus that of a process, ns.
        arrivals: Arrivals of each topic at the filter or the plant.
        resent: Messages of people, in order of time.
        first_numbers: First sequence number by topic, epoch and source.
        started_with: Emergency stop that was latched from the start; 0: none.
        operators: Sessions of operators.
        configured: Links that were set while it ran.
        doubts: What the log does not show, in words.
    """

    path: Path
    scenario: Scenario
    is_virtual: bool
    sessions: Mapping[str, Sequence[ProcessSession]]
    offsets_ns: Mapping[str, int]
    arrivals: Mapping[Topic, Arrivals]
    resent: Sequence[Resent]
    first_numbers: Mapping[tuple[str, int, str], int]
    started_with: int
    operators: int
    configured: frozenset[str]
    doubts: tuple[str, ...]

    def was_impaired(self, link: str) -> bool:
        """Return whether an injected link may have had an effect."""
        planned = {*self.scenario.links, *(change.link for change in self.scenario.link_changes)}
        return link in planned or link in self.configured

    @classmethod
    def of(cls, log: RunLog) -> Self:
        """Read it from a log.

        Raises:
            RerunError: The log does not show what a re-run starts from.
        """
        states = log.of(PlantState)
        if not states or not log.of(FilterTick):
            raise RerunError(log.path, "cannot be run again: it has no states of the plant or no ticks of the filter")
        begins_ns = states[0].body.plant_ns
        if begins_ns:
            raise RerunError(log.path, f"cannot be run again: got plant time {begins_ns / 1e9:g} s first, allowed 0")
        scenario, is_virtual = log.identity.scenario, log.identity.timing == "lockstep"
        period = period_ns(scenario)
        sessions = {name: sessions_of(log, name, period) for name in (PLANT, FILTER)}
        if is_virtual:
            sessions[FILTER] = _on_the_grid(sessions[FILTER], sessions[PLANT])
        offsets = _clock_offsets_ns(log, sessions)
        commands = log.of(OperatorCommand)
        steps = _operator_sessions(log) or [_like(sessions[PLANT][0])]
        return cls(
            path=log.path,
            scenario=scenario,
            is_virtual=is_virtual,
            sessions={**sessions, OPERATOR: steps[:1]},
            offsets_ns=offsets,
            arrivals={
                COMMAND: at_the_filter(log, COMMAND, offsets[OPERATOR]),
                STATE: at_the_filter(log, STATE, offsets[PLANT]),
                INPUT: _inputs_at_the_plant(log, sessions[PLANT]),
                STOP: stops_at_the_plant(log, STOP),
                CLEAR: stops_at_the_plant(log, CLEAR),
            },
            resent=_resent(log, offsets),
            first_numbers=_first_numbers(log),
            started_with=states[0].body.stop,
            operators=len({message.header.epoch for message in commands}),
            configured=frozenset(message.body.link for message in log.of(LinkConfig)),
            doubts=_doubts(log),
        )


def _inputs_at_the_plant(log: RunLog, plants: Sequence[ProcessSession]) -> Arrivals:
    """Return when the bus delivered inputs to the plant."""
    scenario, name = log.identity.scenario, INPUT.links[PLANT]
    changes = [*(change.link for change in scenario.link_changes), *(each.body.link for each in log.of(LinkConfig))]
    if name not in scenario.links and name not in changes:
        return at_the_plant(log, plants)
    inputs, settings = log.of(PlantInput), link_settings(scenario)
    if name in changes or len(plants) > 1 or name not in settings:
        return Arrivals({}, USUAL_LATENCY_NS)
    events = [event.body for event in log.of(LinkEvent) if event.body.link == name]
    found = delivered(
        inputs,
        places(each.header for each in inputs),
        log.of(PlantState),
        plants[0],
        period_ns(scenario),
        settings[name],
        events,
    )
    return Arrivals(found, USUAL_LATENCY_NS)


def _on_the_grid(filters: Sequence[ProcessSession], plants: Sequence[ProcessSession]) -> list[ProcessSession]:
    """Return the filter's sessions with every step of virtual time: it steps whether or not it has to say something."""
    grid = [step for session in plants for step in session.steps]
    whole = []
    for number, session in enumerate(filters):
        begins_ns = 0 if number == 0 else session.steps[0].scheduled_ns
        ends_ns = 2**62 if number == len(filters) - 1 else session.steps[-1].scheduled_ns
        steps = [step for step in grid if begins_ns <= step.scheduled_ns <= ends_ns]
        whole.append(ProcessSession(process=FILTER, epoch=session.epoch, clock_id=session.clock_id, steps=steps))
    return whole


def _operator_sessions(log: RunLog) -> list[ProcessSession]:
    found: dict[int, list[Step]] = {}
    clocks: dict[int, int] = {}
    for header, _ in log.of(OperatorCommand):
        found.setdefault(header.epoch, []).append(Step.of(header))
        clocks[header.epoch] = header.clock_id
    return [
        ProcessSession(process=OPERATOR, epoch=epoch, clock_id=clocks[epoch], steps=steps)
        for epoch, steps in found.items()
    ]


def _like(plant: ProcessSession) -> ProcessSession:
    return ProcessSession(process=OPERATOR, epoch=plant.epoch, clock_id=plant.clock_id, steps=plant.steps)


def _clock_offsets_ns(log: RunLog, sessions: Mapping[str, Sequence[ProcessSession]]) -> dict[str, int]:
    """Return the filter's clock minus that of each process; 0 where both read the same."""
    own = sessions[FILTER][0].clock_id
    consumed: dict[str, dict[tuple[int, int], int]] = {COMMAND.name: {}, STATE.name: {}}
    for tick in log.of(FilterTick):
        for each in tick.body.consumed:
            consumed[each.topic][each.epoch, each.sequence] = each.received_ns
    offsets = {FILTER: 0, PLANT: 0, OPERATOR: 0}
    for name, body in ((PLANT, PlantState), (OPERATOR, OperatorCommand)):
        messages = log.of(body)
        if messages and messages[0].header.clock_id != own:
            offsets[name] = clock_offset_ns((each.header for each in messages), consumed[TOPIC_OF_BODY[body].name])
    return offsets


def _resent(log: RunLog, offsets_ns: Mapping[str, int]) -> list[Resent]:
    found: list[Resent] = []
    for body in RESENT:
        messages = log.of(body)
        topic = TOPIC_OF_BODY[body]
        for place, (header, message) in zip(places(each.header for each in messages), messages, strict=True):
            offset_ns = offsets_ns.get(header.source, 0)
            found.append(Resent(topic=topic, header=header, body=message, number=place.number, offset_ns=offset_ns))
    found.sort(key=lambda each: each.header.started_ns + each.offset_ns)
    return found


def _first_numbers(log: RunLog) -> dict[tuple[str, int, str], int]:
    first: dict[tuple[str, int, str], int] = {}
    for name, messages in log.messages.items():
        for header, _ in messages:
            key = (name, header.epoch, header.source)
            first[key] = min(first.get(key, header.sequence), header.sequence)
    return first


def _doubts(log: RunLog) -> tuple[str, ...]:
    gaps = {name: count.gaps for name, count in log.counts.items() if count.gaps}
    bodies: tuple[type[Message], ...] = (PlantState, FilterTick, OperatorCommand)
    missing = [
        f"{gaps[TOPIC_OF_BODY[body].name]} of {TOPIC_OF_BODY[body].name}"
        for body in bodies
        if TOPIC_OF_BODY[body].name in gaps
    ]
    return (f"messages are missing in the log: {', '.join(missing)}",) if missing else ()
