"""Links in the closed loop in virtual time: every effect, planned changes, and an account that balances."""

from collections import Counter
from pathlib import Path

import pytest
from passafe_protocol.codec import encode
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.messages import FilterTick, Header, LinkEvent, LinkState, Message, OperatorCommand, PlantState
from passafe_protocol.topics import LINKS, Topic
from passafe_services.filter.build import filter_node
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.loop.errors import LinkNameError
from passafe_services.loop.lockstep import Lockstep
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.link_accounts import link_accounts
from passafe_services.tools.review.run_log import RunLog

EVERYTHING = {
    "delay_s": 0.02,
    "jitter_s": 0.01,
    "distribution": "pareto",
    "correlation": 0.5,
    "loss": 0.05,
    "burst_enter": 0.02,
    "burst_leave": 0.3,
    "duplicate": 0.1,
    "corrupt": 0.05,
    "rate_hz": 800.0,
    "queue": 10,
    "outages_s": [(0.1, 0.15)],
    "seed": 4,
}


class Trace:
    """Observer that keeps what was sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[Topic, Header, Message]] = []

    def __call__(self, topic: Topic, header: Header, body: Message) -> None:
        self.sent.append((topic, header, body))

    def of(self, kind: type) -> list[tuple[Header, Message]]:
        return [(header, body) for _, header, body in self.sent if isinstance(body, kind)]

    def last_states(self) -> dict[str, LinkState]:
        return {body.link: body for _, body in self.of(LinkState) if isinstance(body, LinkState)}

    def wire(self) -> list[bytes]:
        return [encode(header, body) for _, header, body in self.sent]


def run(duration_s: float = 0.5, **overrides: object) -> Trace:
    values = {key.replace("__", "."): value for key, value in overrides.items()} | {"duration_s": duration_s}
    scenario = load_scenario("notomista-cai-2020", values)
    trace = Trace()
    loop = lockstep_loop(scenario, trace)
    loop.run(steps_of(scenario))
    loop.finish()
    return trace


def sent(trace: Trace, link: str) -> int:
    return sum(topic is LINKS[link].topic for topic, _, _ in trace.sent)


def balances(state: LinkState) -> bool:
    dropped = state.dropped_loss + state.dropped_queue + state.dropped_outage
    return state.entered + state.duplicated == state.delivered + dropped + state.in_flight


def test_every_effect_is_reported_and_the_account_balances() -> None:
    trace = run(**{f"links.{name}": EVERYTHING for name in LINKS})
    events = Counter((e.link, e.effect, e.cause) for _, e in trace.of(LinkEvent) if isinstance(e, LinkEvent))
    states = trace.last_states()

    assert set(states) == set(LINKS)
    for name, state in states.items():
        assert state.trigger == "end"
        assert balances(state)
        assert state.entered == sent(trace, name) == state.sources[0].received
        assert (state.dropped_loss, state.dropped_queue, state.dropped_outage) == tuple(
            events[name, "dropped", cause] for cause in ("loss", "queue", "outage")
        )
        assert state.duplicated == events[name, "duplicated", ""] > 0
        assert state.corrupted == events[name, "corrupted", ""] > 0
        assert 0 < state.refused_corrupted <= state.corrupted
        assert state.refused_duplicate > 0
        assert state.dropped_queue > 0
    assert {header.source for header, body in trace.of(LinkEvent) if body.link == "plant-to-operator"} == {"operator"}


def test_filter_consumes_what_the_link_delivered_and_accepted() -> None:
    trace = run(**{f"links.{name}": EVERYTHING for name in LINKS})
    ticks = [body for _, body in trace.of(FilterTick) if isinstance(body, FilterTick)]
    consumed = Counter(message.topic for tick in ticks for message in tick.consumed)

    for name in ("operator-to-filter", "plant-to-filter"):
        state = trace.last_states()[name]
        assert consumed[state.topic] == state.delivered - state.refused_corrupted - state.refused_duplicate


def test_links_that_do_nothing_are_accounted_for_too() -> None:
    trace = run(**{"links.plant-to-filter": {"delay_s": 0.01}})
    states = trace.last_states()

    for name in ("operator-to-filter", "filter-to-plant", "plant-to-operator"):
        assert states[name].entered == states[name].delivered == sent(trace, name) > 0
        assert states[name].in_flight == 0
    assert states["plant-to-filter"].in_flight == 10
    assert balances(states["plant-to-filter"])


def test_link_states_are_reported_at_start_end_and_every_second() -> None:
    reported = [
        (body.trigger, header.sent_ns) for header, body in run(2.2).of(LinkState) if body.link == "filter-to-plant"
    ]

    assert [trigger for trigger, _ in reported] == ["start", "period", "period", "end"]
    assert [(at_ns - reported[0][1]) / 1e9 for _, at_ns in reported[:3]] == [0.0, 1.0, 2.0]


def test_planned_changes_take_effect_on_time() -> None:
    changes = [
        {"at_s": 0.2, "link": "operator-to-filter", "settings": {"loss": 1.0}},
        {"at_s": 0.1, "link": "operator-to-filter", "settings": {"delay_s": 0.03}},
        {"at_s": 0.3, "link": "operator-to-filter", "settings": {"loss": 0.0}},
    ]
    trace = run(0.4, link_changes=changes)
    start_ns = trace.of(OperatorCommand)[0][0].sent_ns
    lost = [e.sequence for _, e in trace.of(LinkEvent) if isinstance(e, LinkEvent)]
    reported = [
        (body.trigger, (header.sent_ns - start_ns) / 1e9, body.parameters.delay_s, body.parameters.loss)
        for header, body in trace.of(LinkState)
        if body.link == "operator-to-filter"
    ]

    assert lost == list(range(200, 300))
    assert reported[:-1] == [
        ("start", 0.0, 0.0, 0.0),
        ("scheduled", 0.1, 0.03, 0.0),
        ("scheduled", 0.2, 0.03, 1.0),
        ("scheduled", 0.3, 0.03, 0.0),
    ]
    ages = {tick.tick: tick.command_age_ns for _, tick in trace.of(FilterTick) if isinstance(tick, FilterTick)}
    assert ages[50] == 0
    assert max(ages.values()) >= 100_000_000


def test_runs_with_every_effect_are_the_same_to_the_last_byte() -> None:
    overrides = {f"links.{name}": EVERYTHING for name in LINKS}

    assert run(0.3, **overrides).wire() == run(0.3, **overrides).wire()


def test_an_observer_changes_nothing_about_the_run() -> None:
    scenario = load_scenario(
        "notomista-cai-2020", {"duration_s": 0.3, **{f"links.{name}": EVERYTHING for name in LINKS}}
    )
    seen, unseen = lockstep_loop(scenario, Trace()), lockstep_loop(scenario)
    for loop in (seen, unseen):
        loop.run(steps_of(scenario))
        loop.finish()

    states = [[link.counts for slot in loop._slots for link in slot.links] for loop in (seen, unseen)]
    assert states[0] == states[1]


def test_what_the_operator_sees_is_late_too() -> None:
    scenario = load_scenario("notomista-cai-2020", {"links.plant-to-operator": {"delay_s": 0.1}})
    loop = lockstep_loop(scenario)
    loop.run(300)
    operator = next(slot.node for slot in loop._slots if slot.name == "operator")
    plant = next(slot.node for slot in loop._slots if slot.name == "plant")

    assert isinstance(operator._state, PlantState)
    assert plant.plant_ns - operator._state.plant_ns == 100_000_000


def test_a_link_that_does_not_exist_is_refused() -> None:
    with pytest.raises(LinkNameError, match="filter-to-moon"):
        Lockstep([], period_ns=1, links={"filter-to-moon": LinkSettings()})


def test_links_of_a_killed_reader_are_accounted_for(tmp_path: Path) -> None:
    overrides = {"duration_s": 0.6, **{f"links.{name}": EVERYTHING for name in LINKS}}
    scenario = load_scenario("notomista-cai-2020", overrides)
    path = tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as log:
        loop = lockstep_loop(scenario, LockstepLog(log))
        loop.run(200)
        loop.kill("filter")
        loop.run(100)
        loop.restart(filter_node(scenario, "lockstep", 2), 2)
        loop.run(300)
        loop.finish()
    accounts = link_accounts(RunLog.read(path))

    assert [account.link for account in accounts] == list(LINKS)
    assert [account.differences for account in accounts] == [{}] * 4
    assert accounts[0].sent == 600
