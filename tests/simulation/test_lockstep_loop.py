"""The closed loop in virtual time, nodes and links as live."""

import numpy as np
import pytest
from passafe_protocol.codec import encode
from passafe_protocol.messages import FilterStatus, FilterTick, Header, LinkEvent, Message, PlantPhase, PlantState
from passafe_protocol.topics import STATE, TICK, Topic
from passafe_services.filter.telemetry import TickRecord
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import CompiledScenario, lockstep_loop, steps_of

LINKS = ("operator-to-filter", "filter-to-plant", "plant-to-filter")


class Trace:
    """Observer that keeps what was sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[Topic, Header, Message]] = []

    def __call__(self, topic: Topic, header: Header, body: Message) -> None:
        self.sent.append((topic, header, body))

    def of(self, kind: type) -> list[Message]:
        return [body for _, _, body in self.sent if isinstance(body, kind)]

    def moving(self) -> list[PlantState]:
        return [b for b in self.of(PlantState) if isinstance(b, PlantState) and b.phase is not PlantPhase.WAITING]

    def wire(self) -> list[bytes]:
        return [encode(header, body) for _, header, body in self.sent]


def run(duration_s: float = 1.0, **overrides: object) -> Trace:
    values = {key.replace("__", "."): value for key, value in overrides.items()} | {"duration_s": duration_s}
    scenario = load_scenario("notomista-cai-2020", values)
    trace = Trace()
    lockstep_loop(scenario, trace).run(steps_of(scenario))
    return trace


def bad_links(**settings: float) -> dict[str, object]:
    return {f"links.{name}": settings for name in LINKS}


@pytest.fixture(scope="module")
def paper() -> Trace:
    return run(10.0)


def test_mode_both_keeps_barrier_and_power_margin(paper: Trace) -> None:
    x = np.array([state.x for state in paper.moving()])
    u = np.array([state.u for state in paper.moving()])
    x1, x2 = x[:, :2], x[:, 2:]
    margin = 2 * (x2**2).sum(1) - 2 * (x1 * x2).sum(1) - (x2 * u).sum(1)

    assert len(x) == 10_001
    assert x1[-1] == pytest.approx([-0.9996, 0.0295], abs=2e-3)
    assert (x1**2).sum(1).min() - 1 >= -1e-6
    assert margin.min() >= -2e-4


def test_every_tick_is_certified(paper: Trace) -> None:
    ticks = [body for body in paper.of(FilterTick) if isinstance(body, FilterTick)]

    assert {tick.status for tick in ticks} == {FilterStatus.PASSED, FilterStatus.MODIFIED}
    assert all(tick.certificate.accepted for tick in ticks)
    assert max(tick.certificate.primal_residual for tick in ticks) <= 1e-6


def test_plant_confirms_the_prediction_to_the_last_bit(paper: Trace) -> None:
    truth = {state.plant_ns: state for state in paper.moving()}
    ticks = [body for body in paper.of(FilterTick) if isinstance(body, FilterTick)]
    compared = [tick for tick in ticks if tick.effective_plant_ns in truth]

    assert len(compared) == 10_001
    assert all(truth[tick.effective_plant_ns].x == tick.x_hat for tick in compared)
    assert all(truth[tick.effective_plant_ns].u == tick.u for tick in compared)


def test_two_runs_with_bad_links_are_byte_identical() -> None:
    overrides = bad_links(delay_s=0.02, jitter_s=0.01, loss=0.1, seed=4)

    first, second = run(0.5, **overrides).wire(), run(0.5, **overrides).wire()

    assert first == second


def test_another_seed_gives_another_run() -> None:
    first = run(0.3, **bad_links(loss=0.3, seed=4)).wire()

    assert run(0.3, **bad_links(loss=0.3, seed=5)).wire() != first


def test_delay_alone_does_not_affect_safety() -> None:
    trace = run(4.0, **bad_links(delay_s=0.2))
    x = np.array([state.x for state in trace.moving()])

    assert (x[:, :2] ** 2).sum(1).min() - 1 >= -1e-6


def test_lost_messages_are_reported_by_the_reader_of_the_link() -> None:
    trace = run(0.3, **{"links.plant-to-filter": {"loss": 0.5, "seed": 1}})
    dropped = [body for body in trace.of(LinkEvent) if isinstance(body, LinkEvent)]

    assert {(event.link, event.effect, event.topic) for event in dropped} == {("plant-to-filter", "dropped", "state")}
    assert 0.35 < len(dropped) / len(trace.of(PlantState)) < 0.65


def test_continuous_law_diverges_in_passive_and_is_reported() -> None:
    trace = run(4.0, filter__law="continuous", filter__mode="passive")
    ticks = [body for body in trace.of(FilterTick) if isinstance(body, FilterTick)]
    u = np.array([state.u for state in trace.moving()])
    infeasible = [tick.effective_plant_ns * 1e-9 for tick in ticks if tick.status is FilterStatus.INFEASIBLE]

    assert min(infeasible) == pytest.approx(2.23, abs=0.05)
    assert np.abs(u).max() <= 100.0
    assert len(ticks) == 4006


def test_tap_gets_outgoing_items_without_computing_messages() -> None:
    scenario = load_scenario("notomista-cai-2020", {"duration_s": 0.05})
    trace, states, records = Trace(), [], []
    lockstep_loop(scenario, trace, taps={STATE: states.append, TICK: records.append}).run(steps_of(scenario))
    alone: list[object] = []
    lockstep_loop(scenario, taps={TICK: alone.append}).run(steps_of(scenario))

    assert states == trace.of(PlantState)
    assert all(isinstance(record, TickRecord) for record in [*records, *alone])
    assert [record() for record in records] == trace.of(FilterTick)
    assert len(alone) == len(records)


def test_loops_one_after_the_other_may_share_what_was_derived() -> None:
    links = bad_links(delay_s=0.01, loss=0.2)
    scenarios = [load_scenario("notomista-cai-2020", {"duration_s": 0.2} | more) for more in ({}, links)]
    compiled = CompiledScenario.of(scenarios[0])
    traces = []
    for scenario in (*scenarios, *scenarios):
        traces.append(Trace())
        lockstep_loop(scenario, traces[-1], compiled=compiled).run(steps_of(scenario))
    alone = Trace()
    lockstep_loop(scenarios[1], alone).run(steps_of(scenarios[1]))

    assert CompiledScenario.key_of(scenarios[0]) == CompiledScenario.key_of(scenarios[1])
    assert traces[0].wire() == traces[2].wire()
    assert traces[1].wire() == traces[3].wire() == alone.wire()


@pytest.mark.parametrize(
    "overrides",
    [
        {"filter.mode": "off"},
        {"filter.k_i": 50.0},
        {"filter.barriers.disk.radius": 0.5},
        {"rate_hz": 500.0},
        {"plant.parameters.sigma": 2.0},
        {"filter.passivity.storage": "kinetic"},
    ],
)
def test_what_is_derived_anew_has_another_key(overrides: dict[str, object]) -> None:
    plain, other = load_scenario("notomista-cai-2020"), load_scenario("notomista-cai-2020", overrides)

    assert CompiledScenario.key_of(plain) != CompiledScenario.key_of(other)


def test_loop_without_observer_computes_no_telemetry() -> None:
    scenario = load_scenario("notomista-cai-2020", {"duration_s": 0.05})
    loop = lockstep_loop(scenario)
    loop.run(steps_of(scenario))

    assert loop.now_ns > 0
