"""Strategies for any message that the protocol can carry."""

from typing import Any

from hypothesis import strategies as st
from passafe_protocol.link_effect import CAUSES, EFFECTS
from passafe_protocol.link_settings import DISTRIBUTIONS, MAX_DELAY_S
from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    Consumed,
    EmergencyStop,
    Event,
    FilterStatus,
    FilterTick,
    Header,
    Health,
    LinkConfig,
    LinkEvent,
    LinkOutage,
    LinkParameters,
    LinkSource,
    LinkState,
    OperatorCommand,
    OperatorLease,
    OverrideReport,
    PlantInput,
    PlantPhase,
    PlantState,
    Receipt,
    RecordedSession,
    RowReport,
    ScenarioInfo,
    Steer,
    StopClear,
    TopicHealth,
)
from passafe_protocol.topics import LINKS

number = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(min_value=0, allow_nan=False, allow_infinity=False)
count = st.integers(0, 2**64 - 1)
identity = st.integers(1, 2**64 - 1)
time_ns = st.integers(-(2**63), 2**63 - 1)
age_ns = st.integers(-1, 2**63 - 1)
text = st.text(max_size=20)
name = st.text(min_size=1, max_size=20)


def vector(size: int) -> st.SearchStrategy[tuple[float, ...]]:
    return st.tuples(*[number] * size)


def tuple_of(element: st.SearchStrategy[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(element, max_size=4).map(tuple)


def ticks(m: int) -> st.SearchStrategy[FilterTick]:
    absent_or_m = st.sampled_from([0, m]).flatmap(vector)
    return st.builds(
        FilterTick,
        tick=count,
        status=st.sampled_from(FilterStatus),
        mode=st.sampled_from(["off", "safe", "passive", "both"]),
        law=st.sampled_from(["sampled", "continuous"]),
        effective_plant_ns=time_ns,
        x_hat=st.integers(0, 6).flatmap(vector),
        u_h=absent_or_m,
        u_h_rate=absent_or_m,
        u_nominal=absent_or_m,
        phi=absent_or_m,
        v=absent_or_m,
        u=vector(m),
        barriers=tuple_of(st.builds(BarrierReport, name, st.integers(1, 4).flatmap(vector), number)),
        power_margin=number,
        tank_j=number,
        slack=number,
        rows=tuple_of(st.builds(RowReport, name, number, number, st.booleans(), number, positive)),
        certificate=st.builds(Certificate, text, st.booleans(), number, positive, positive),
        consumed=tuple_of(st.builds(Consumed, name, count, time_ns, count)),
        state_age_ns=age_ns,
        command_age_ns=age_ns,
        override=st.builds(OverrideReport, absent_or_m, st.floats(0, 1), st.booleans(), number),
    )


def states(m: int) -> st.SearchStrategy[PlantState]:
    return st.builds(
        PlantState,
        plant_ns=time_ns,
        x=st.sampled_from([1, 4, 64]).flatmap(vector),
        y=vector(m),
        u=vector(m),
        applied_tick=count,
        phase=st.sampled_from(PlantPhase),
        energy_in_j=number,
        energy_stored_j=number,
        input_lead_ns=time_ns,
        inputs_late=count,
        inputs_refused=count,
        integration_error=positive,
        received_tick=count,
        stop=count,
        stop_source=text,
        stops_cleared=count,
    )


def commands(m: int) -> st.SearchStrategy[OperatorCommand]:
    rate = st.sampled_from([0, m]).flatmap(vector)
    return st.builds(OperatorCommand, u_h=vector(m), u_h_rate=rate, enabled=st.booleans(), device=name, take_over=count)


share = st.floats(0, 1)
parameters = st.builds(
    LinkParameters,
    delay_s=st.floats(0, MAX_DELAY_S),
    jitter_s=st.floats(0, MAX_DELAY_S),
    distribution=st.sampled_from(DISTRIBUTIONS),
    quantiles_s=tuple_of(st.floats(0, MAX_DELAY_S)),
    correlation=st.floats(0, 0.9999),
    reorder=st.booleans(),
    loss=share,
    burst_enter=share,
    burst_leave=share,
    burst_loss_good=share,
    burst_loss_bad=share,
    duplicate=share,
    corrupt=share,
    rate_hz=st.floats(0, 1e6),
    queue=st.integers(1, 1000),
    outages=tuple_of(st.builds(LinkOutage, st.floats(0, 1e6), st.floats(0, 1e6))),
    seed=count,
)
sizes = st.sampled_from([1, 2, 7])
headers = st.builds(Header, name, count, count, time_ns, time_ns, time_ns, time_ns)
MESSAGES: dict[type, st.SearchStrategy[Any]] = {
    OperatorCommand: sizes.flatmap(commands),
    Steer: st.builds(
        Steer,
        turn=identity,
        driver=st.just("page"),
        page=st.integers(1, 2**32 - 1),
        shares=st.lists(st.floats(-1, 1), max_size=4).map(tuple),
        engaged=st.booleans(),
        age_ns=st.integers(0, 2**63 - 1),
        take_over=st.booleans(),
        echoed_epoch=count,
        echoed_ns=time_ns,
        echoed_for_ns=st.integers(0, 2**63 - 1),
    ),
    EmergencyStop: st.builds(EmergencyStop, id=identity, reason=name),
    StopClear: st.builds(StopClear, stop=identity, reason=name),
    OperatorLease: st.builds(
        OperatorLease, number=count, holder=count, device=text, command_age_ns=age_ns, refused=count
    ),
    PlantInput: st.builds(
        PlantInput, tick=count, u=sizes.flatmap(vector), effective_plant_ns=time_ns, hold_ns=count, stops_cleared=count
    ),
    PlantState: sizes.flatmap(states),
    FilterTick: sizes.flatmap(ticks),
    LinkConfig: st.builds(LinkConfig, link=st.sampled_from(sorted(LINKS)), parameters=parameters),
    LinkEvent: st.builds(
        LinkEvent,
        link=st.sampled_from(sorted(LINKS)),
        effect=st.sampled_from(EFFECTS),
        topic=name,
        sequence=count,
        cause=st.sampled_from(["", *CAUSES]),
    ),
    LinkState: st.builds(
        LinkState,
        st.sampled_from(sorted(LINKS)),
        name,
        parameters,
        *[count] * 11,
        st.sampled_from(["start", "period", "scheduled", "requested", "end"]),
        text,
        count,
        count,
        text,
        tuple_of(st.builds(LinkSource, name, count, count, count, count)),
    ),
    Health: st.builds(
        Health,
        rate_hz=positive,
        steps=count,
        overruns=count,
        steps_skipped=count,
        late_us_max=positive,
        topics=tuple_of(st.builds(TopicHealth, name, count, count, count)),
    ),
    Receipt: st.builds(Receipt, sessions=tuple_of(st.builds(RecordedSession, name, name, count, count))),
    Event: st.builds(Event, severity=st.sampled_from(["info", "warning", "error"]), text=name),
    ScenarioInfo: st.builds(
        ScenarioInfo, scenario_json=name, driver=st.sampled_from(["live", "lockstep"]), versions_json=name
    ),
}
