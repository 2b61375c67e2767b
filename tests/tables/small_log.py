"""A log of a handful of messages with numbers that a test can name."""

from pathlib import Path

from passafe_protocol.codec import encode
from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    Event,
    FilterStatus,
    FilterTick,
    Header,
    Health,
    Message,
    PlantPhase,
    PlantState,
    RowReport,
    TopicHealth,
)
from passafe_protocol.topics import TOPIC_OF_BODY
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.scenarios.load import load_scenario

WALL_NS = 1_763_800_000_000_000_000
PERIOD_NS = 1_000_000
LARGE = 2**63 + 11
"""Epoch that only an unsigned number of 64 bits holds."""


def header(source: str, k: int) -> Header:
    """Return the header of message k of a process, a period after the one before."""
    t_ns = k * PERIOD_NS
    return Header(source, LARGE, k, t_ns, t_ns, t_ns, WALL_NS + t_ns)


def state(k: int, *, x1: float | None = None) -> PlantState:
    """Return the k-th state; x₁ is k unless given."""
    return PlantState(
        plant_ns=k * PERIOD_NS,
        x=(float(k) if x1 is None else x1, 2.0, 0.0, -1.0),
        y=(0.0, -1.0),
        u=(0.1, 0.2),
        applied_tick=k,
        phase=PlantPhase.RUNNING,
        energy_in_j=0.0,
        energy_stored_j=5.0,
        input_lead_ns=-k,
        inputs_late=0,
        inputs_refused=0,
        integration_error=0.0,
        received_tick=k,
    )


def tick(k: int, *, rows: tuple[str, ...] = ("disk", "passivity"), barriers: tuple[str, ...] = ("disk",)) -> FilterTick:
    """Return the k-th tick, whose h is k + 0.5."""
    return FilterTick(
        tick=k,
        status=FilterStatus.MODIFIED,
        mode="both",
        law="sampled",
        effective_plant_ns=k * PERIOD_NS,
        x_hat=(1.0, 2.0, 3.0, 4.0),
        u_h=(0.0, 0.0),
        u_h_rate=(),
        u_nominal=(1.0, 0.0),
        phi=(0.0, 0.0),
        v=(0.0, 0.0),
        u=(1.0, 0.0),
        barriers=tuple(BarrierReport(name, (k + 0.5, 2.0, 3.0), 0.25) for name in barriers),
        power_margin=0.5,
        tank_j=1.0,
        slack=0.0,
        rows=tuple(RowReport(name, 0.75, 0.0, active=True) for name in rows),
        certificate=Certificate("piqp", accepted=True, primal_residual=0.0, dual_residual=0.0, gap=0.0),
        consumed=(),
        state_age_ns=1000,
        command_age_ns=2000,
    )


def health(*topics: str) -> Health:
    """Return the health of a process that read some topics."""
    return Health(1000.0, 10, 0, 0, 12.5, tuple(TopicHealth(topic, 7, 1, 0) for topic in topics))


def write_log(path: Path, messages: list[tuple[str, int, Message]], scenario: str = "notomista-cai-2020") -> Path:
    """Write messages, each given as source, number and body, in the order given."""
    text = load_scenario(scenario).model_dump_json()
    metadata = run_metadata(scenario_json=text, versions={"passafe": "0"}, driver="lockstep")
    with LogWriter(path, metadata) as log:
        for source, k, body in messages:
            head, topic = header(source, k), TOPIC_OF_BODY[type(body)]
            log.write(topic.key(source), encode(head, body), sequence=k, wall_ns=head.wall_ns)
    return path


def small_log(path: Path) -> Path:
    """Write a log of 4 states, 3 ticks, an event and the health of two processes."""
    messages: list[tuple[str, int, Message]] = [("plant", k, state(k)) for k in range(4)]
    messages += [("filter", 0, tick(0, rows=())), ("filter", 1, tick(1)), ("filter", 2, tick(2))]
    messages += [("filter", 3, Event("warning", 'the disk, "near"'))]
    messages += [("plant", 3, health("input")), ("filter", 3, health("state", "command"))]
    return write_log(path, messages)
