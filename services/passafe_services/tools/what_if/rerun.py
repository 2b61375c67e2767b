"""Re-runs a log in closed loop, as it was or with something changed."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import LinkConfig, LinkSource, OperatorCommand, Received
from passafe_protocol.topics import CLEAR, COMMAND, INPUT, LEASE, LINKS, STATE, STOP, Topic

from passafe_services.filter.build import filter_node
from passafe_services.loop.link_control import LinkControl
from passafe_services.loop.lockstep import Observer
from passafe_services.node import Node
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.links import link_changes, link_settings
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import CompiledScenario, steps_of
from passafe_services.tools.what_if.arrivals import USUAL_LATENCY_NS, Arrivals
from passafe_services.tools.what_if.recorded_run import RecordedRun
from passafe_services.tools.what_if.recorded_steps import FILTER, OPERATOR, PLANT, ProcessSession
from passafe_services.tools.what_if.rerun_loop import Process, RerunLoop, Resent, SentMessages
from passafe_services.tools.what_if.route import BusRoute, DirectRoute, RecordedRoute, Route, VirtualRoute

Links = Literal["recorded", "drawn"]

SUBSCRIPTIONS: Final[dict[str, tuple[Topic, ...]]] = {
    PLANT: (STOP, CLEAR, INPUT),
    FILTER: (COMMAND, STATE),
    OPERATOR: (STATE, LEASE),
}
"""Topics that reach each node, in the order of its inlets."""

_READER_OF_ARRIVALS: Final = {COMMAND: FILTER, STATE: FILTER, INPUT: PLANT, STOP: PLANT, CLEAR: PLANT}


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Conditions of a re-run.

    Attributes:
        scenario: Its scenario.
        operator_acts: Whether the operator of ``scenario`` drives, instead of the commands in the log.
        links: Whether unchanged links do to each message what they did in the log, or draw anew.
        seed: Added to the seeds of links that draw anew.
    """

    scenario: Scenario
    operator_acts: bool = False
    links: Links = "recorded"
    seed: int = 1

    @property
    def settings(self) -> dict[str, LinkSettings]:
        """Settings of the injected links by name."""
        found = link_settings(self.scenario)
        if self.links == "recorded":
            return found
        return {name: replace(each, seed=(each.seed + self.seed) % 2**63) for name, each in found.items()}


def rerun_loop(
    run: RecordedRun, conditions: Conditions, observer: Observer, compiled: CompiledScenario | None = None
) -> RerunLoop:
    """Return the loop of a re-run.

    Args:
        run: The logged run.
        conditions: Conditions of the re-run.
        observer: Called with every message.
        compiled: The compiled scenario, if there is one already.
    """
    scenario = conditions.scenario
    compiled = CompiledScenario.of(scenario) if compiled is None else compiled
    sent = SentMessages(dict(run.first_numbers))
    names = (PLANT, FILTER, *((OPERATOR,) if conditions.operator_acts else ()))
    routes: dict[Topic, list[tuple[Process, Route]]] = {}
    processes = []
    for name in names:
        process = _process(name, run, conditions, compiled, sent)
        for topic, route in zip(SUBSCRIPTIONS[name], process.routes, strict=True):
            routes.setdefault(topic, []).append((process, route))
        processes.append(process)
    return RerunLoop(processes, routes, _resent(run, conditions), sent, observer)


def _process(
    name: str, run: RecordedRun, conditions: Conditions, compiled: CompiledScenario, sent: SentMessages
) -> Process:
    settings, changes = conditions.settings, link_changes(conditions.scenario)
    inbox: list[Received] = []
    links = {
        topic: MessageLink(topic.links[name], settings.get(topic.links[name], LinkSettings()))
        for topic in SUBSCRIPTIONS[name]
        if name in topic.links and not _is_as_recorded(topic, name, run, conditions)
    }
    entered: dict[str, BusRoute] = {}

    def sources_of(link: MessageLink) -> tuple[LinkSource, ...]:
        return entered[link.name].sources if link.name in entered else sent.sources(link)

    control = LinkControl(links.values(), changes, sources_of)
    injected = {*settings, *(change.link for change in changes)}
    routes: list[Route] = []
    for topic in SUBSCRIPTIONS[name]:
        link = links.get(topic)
        arrivals = _arrivals(topic, name, run)
        if run.is_virtual:
            has_effect = link is not None and link.name in injected
            routes.append(VirtualRoute(link, control) if link is not None and has_effect else DirectRoute(link, inbox))
        elif link is None and name in topic.links:
            routes.append(RecordedRoute(arrivals.at, arrivals.latency_ns))
        else:
            is_of_bus = name == PLANT or not run.was_impaired(topic.links.get(name, ""))
            route = BusRoute(link, arrivals.at if is_of_bus else {}, USUAL_LATENCY_NS)
            routes.append(route)
            entered |= {} if link is None else {link.name: route}
    return Process(
        name=name,
        sessions=_sessions(name, run, conditions.scenario),
        node_of=_node_of(name, run, conditions.scenario, compiled),
        offset_ns=run.offsets_ns[name],
        routes=routes,
        inbox=inbox,
        control=control,
    )


def _node_of(
    name: str, run: RecordedRun, scenario: Scenario, compiled: CompiledScenario
) -> Callable[[ProcessSession], Node]:
    if name == PLANT:
        return lambda _: plant_node(scenario, compiled.model, started_with=run.started_with)
    if name == OPERATOR:
        return lambda session: operator_node(scenario, session.epoch)
    model, core = compiled.model, compiled.filter
    return lambda session: filter_node(scenario, "lockstep", session.epoch, model, core, clock_id=session.clock_id)


def _sessions(name: str, run: RecordedRun, scenario: Scenario) -> Sequence[ProcessSession]:
    """Return the sessions of a process: as recorded, unless rate or duration differ."""
    sessions, before = run.sessions[name], run.scenario
    if scenario.rate_hz == before.rate_hz and (scenario.duration_s == before.duration_s or not run.is_virtual):
        return sessions
    count = steps_of(scenario) if run.is_virtual and len(sessions) == 1 else None
    return [session.at_rate(period_ns(scenario), count) for session in sessions]


def _arrivals(topic: Topic, reader: str, run: RecordedRun) -> Arrivals:
    """Return the arrivals of a topic's messages at a reader, as far as the log shows them."""
    if _READER_OF_ARRIVALS.get(topic) == reader:
        return run.arrivals[topic]
    return Arrivals({}, USUAL_LATENCY_NS)


def _is_as_recorded(topic: Topic, reader: str, run: RecordedRun, conditions: Conditions) -> bool:
    """Return whether the ticks in the log say what becomes of every message of a topic.

    In virtual time links with the same seed do the same to the same messages, so that nothing is looked up; the plant
    does not say which inputs it received, so that its links are drawn with the same seeds, too.
    """
    if run.is_virtual or reader != FILTER:
        return False
    name = topic.links[reader]
    if conditions.links == "drawn" and run.was_impaired(name):
        return False
    before, after = ([*_of_link(scenario, name)] for scenario in (run.scenario, conditions.scenario))
    return before == after and run.scenario.rate_hz == conditions.scenario.rate_hz


def _of_link(scenario: Scenario, name: str) -> Iterator[object]:
    yield link_settings(scenario).get(name, LinkSettings())
    yield from (change for change in link_changes(scenario) if change.link == name)


def _resent(run: RecordedRun, conditions: Conditions) -> Sequence[Resent]:
    """Return what is sent again: not the commands where another operator drives, nor settings of changed links."""
    changed = {name for name in LINKS if [*_of_link(run.scenario, name)] != [*_of_link(conditions.scenario, name)]}

    def is_kept(each: Resent) -> bool:
        if isinstance(each.body, OperatorCommand):
            return not conditions.operator_acts
        return not isinstance(each.body, LinkConfig) or each.body.link not in changed

    return [each for each in run.resent if is_kept(each)]
