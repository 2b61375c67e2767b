"""One valid message of every type, with parts and lists filled."""

import pytest
from link_parameters import PARAMETERS
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
    LinkSource,
    LinkState,
    Message,
    OperatorCommand,
    OperatorLease,
    OverrideReport,
    PlantInput,
    PlantPhase,
    PlantState,
    RowReport,
    ScenarioInfo,
    Steer,
    StopClear,
    TopicHealth,
)

HEADER = Header(
    source="plant",
    epoch=1_763_800_000_000_000_000,
    sequence=300,
    scheduled_ns=5_000_000_000,
    started_ns=5_000_010_000,
    sent_ns=5_000_060_000,
    wall_ns=1_763_800_005_000_060_000,
)

BODIES: tuple[Message, ...] = (
    OperatorCommand(
        u_h=(1.5, -2.0),
        u_h_rate=(0.25, 0.0),
        enabled=True,
        device="lag",
        echoed_epoch=7,
        echoed_ns=-5,
        echoed_for_ns=9,
        take_over=3,
    ),
    Steer(
        turn=4,
        driver="page",
        page=3,
        shares=(1.0, -0.25),
        engaged=True,
        age_ns=20_000_000,
        take_over=True,
        echoed_epoch=8,
        echoed_ns=-6,
        echoed_for_ns=10,
    ),
    EmergencyStop(id=2**64 - 5, reason="pressed at the keyboard"),
    StopClear(stop=2**64 - 5, reason="the way is free"),
    OperatorLease(number=4, holder=1_763_800_000_000_000_002, device="lag", command_age_ns=1_000_000, refused=5),
    PlantInput(
        tick=300,
        u=(0.5, -0.5),
        effective_plant_ns=1_000_000,
        hold_ns=100_000_000,
        input_sequence_start_ns=500_000,
        known_break_ns=-1,
        previous_u=(0.25, -0.25, 0.125, -0.125),
        stops_cleared=2,
    ),
    PlantState(
        plant_ns=-1,
        x=(1.0, 2.0, 3.0, 4.0),
        y=(3.0, 4.0),
        u=(0.5, -0.5),
        applied_tick=299,
        phase=PlantPhase.RUNNING,
        energy_in_j=-0.75,
        energy_stored_j=12.5,
        input_lead_ns=-4_000_000,
        inputs_late=1,
        inputs_refused=2,
        integration_error=1e-12,
        received_tick=300,
        sequence_break_ns=400_000,
        input_since_ns=900_000,
        input_transit_ns=-4_999_000_000,
        input_epoch=1_763_800_000_000_000_001,
        stop=2**64 - 5,
        stop_source="console",
        stops_cleared=2,
    ),
    FilterTick(
        tick=300,
        status=FilterStatus.MODIFIED,
        mode="both",
        law="sampled",
        effective_plant_ns=1_000_000,
        x_hat=(1.0, 2.0, 3.0, 4.0),
        u_h=(1.0, 2.0),
        u_h_rate=(0.5, 0.5),
        u_nominal=(1.0, 1.0),
        phi=(0.1, 0.2),
        v=(0.3, 0.4),
        u=(0.5, 0.6),
        barriers=(BarrierReport("disk", (1.0, 2.0, 3.0), eps=0.125), BarrierReport("wall", (4.0,))),
        power_margin=0.25,
        tank_j=1.5,
        slack=0.0,
        rows=(
            RowReport("disk", 0.5, 0.0, active=False),
            RowReport("passivity", 0.0, 2.0, active=True, share=1.0, relaxed=0.5),
        ),
        certificate=Certificate("piqp", accepted=True, primal_residual=1e-9, dual_residual=2e-9, gap=3e-9),
        consumed=(Consumed("state", 41, 7, 1), Consumed("command", 42, 8, 2)),
        state_age_ns=1_000_000,
        command_age_ns=2_000_000,
        override=OverrideReport((0.75, -0.5), allowed_fraction=0.25, unavoidable=False, distance_to_infeasibility=-3.5),
        horizon_ns=410_000_000,
        command_state="resumes",
        command_share=0.75,
    ),
    LinkConfig(link="filter-to-plant", parameters=PARAMETERS),
    LinkEvent(link="plant-to-filter", effect="dropped", topic="state", sequence=12, cause="queue"),
    LinkState(
        link="plant-to-operator",
        topic="state",
        parameters=PARAMETERS,
        trace_opportunities=3,
        entered=10,
        delivered=6,
        dropped_loss=1,
        dropped_queue=2,
        dropped_outage=1,
        duplicated=3,
        corrupted=2,
        in_flight=3,
        refused_corrupted=1,
        refused_duplicate=1,
        trigger="requested",
        config_source="console",
        config_epoch=1_763_800_000_000_000_001,
        config_sequence=4,
        refusal="link rate_hz: got 5, allowed 0 if there is a trace",
        sources=(LinkSource("plant", 1_763_800_000_000_000_000, 0, 11, 10),),
    ),
    Health(
        rate_hz=999.5,
        steps=1000,
        overruns=3,
        steps_skipped=1,
        late_us_max=250.0,
        topics=(TopicHealth("state", 900, 100, 4),),
    ),
    Event(severity="warning", text="plant: WAITING → RUNNING"),
    ScenarioInfo(scenario_json='{"name": "x"}', driver="live", versions_json='{"passafe": "0.1.0"}'),
)


@pytest.fixture
def header() -> Header:
    return HEADER


@pytest.fixture(params=BODIES, ids=lambda body: type(body).__name__)
def body(request: pytest.FixtureRequest) -> Message:
    """Each valid message in turn."""
    return request.param


@pytest.fixture
def body_of() -> dict[type[Message], Message]:
    """Return a valid message of each type."""
    return {type(body): body for body in BODIES}
