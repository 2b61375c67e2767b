"""An operator node in steps: sources that say what they were asked, and messages to it."""

from dataclasses import dataclass
from itertools import count

from msgspec.structs import replace
from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    FilterStatus,
    FilterTick,
    Header,
    Message,
    OperatorCommand,
    OperatorLease,
    PlantPhase,
    PlantState,
    Received,
)
from passafe_services.operator.node import OperatorNode
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock

MS = 1_000_000
EPOCH = 1_000
NUMBERS = count()


@dataclass
class TimeTeller:
    """A source that says what time it was asked for."""

    device: str = "teller"
    clock: SourceClock = SourceClock.PLANT
    finished: bool = False

    def command(self, t_s: float) -> Command:
        """Return the time as the command."""
        return Command((t_s,), (1.0,), True)


@dataclass
class Onlooker(TimeTeller):
    """A source that keeps what it was shown, and how much of it when it was asked."""

    def __post_init__(self) -> None:
        self.seen: list[int] = []
        self.seen_when_asked: list[int] = []

    def observe(self, state: PlantState) -> None:
        """Keep the plant time."""
        self.seen.append(state.plant_ns // MS)

    def command(self, t_s: float) -> Command:
        """Count what was seen."""
        self.seen_when_asked.append(len(self.seen))
        return super().command(t_s)


def received(body: Message, at_ns: int, *, epoch: int = 1, source: str = "plant") -> Received:
    return Received(Header(source, epoch, next(NUMBERS), at_ns, at_ns, at_ns, at_ns), body, at_ns)


def state(plant_ns: int, at_ns: int, phase: PlantPhase = PlantPhase.RUNNING) -> Received:
    body = PlantState(
        plant_ns=plant_ns,
        x=(1.0, 2.0, 3.0, 4.0),
        y=(3.0, 4.0),
        u=(0.0, 0.0),
        applied_tick=0,
        phase=phase,
        energy_in_j=0.0,
        energy_stored_j=0.0,
        input_lead_ns=0,
        inputs_late=0,
        inputs_refused=0,
        integration_error=0.0,
        received_tick=0,
    )
    return received(body, at_ns)


def stopped(at_ns: int, *, stop: int) -> Received:
    body = state(0, at_ns).body
    assert isinstance(body, PlantState)
    return received(replace(body, stop=stop, stop_source="console" if stop else ""), at_ns)


def lease(holder: int, *, number: int = 1) -> Received:
    return received(OperatorLease(number, holder, "other", 0), 0, source="filter")


def tick(at_ns: int, levels: dict[str, float]) -> Received:
    body = FilterTick(
        tick=1,
        status=FilterStatus.MODIFIED,
        mode="both",
        law="sampled",
        effective_plant_ns=0,
        x_hat=(),
        u_h=(),
        u_h_rate=(),
        u_nominal=(),
        phi=(),
        v=(),
        u=(),
        barriers=tuple(BarrierReport(name, (h, 99.0)) for name, h in levels.items()),
        power_margin=0.0,
        tank_j=0.0,
        slack=0.0,
        rows=(),
        certificate=Certificate("piqp", True, 0.0, 0.0, 0.0),
        consumed=(),
        state_age_ns=0,
        command_age_ns=0,
    )
    return received(body, at_ns, source="filter")


def asked_for(node: OperatorNode, now_ns: int, *inbox: Received) -> float:
    """Time in seconds for which the node asked its TimeTeller."""
    (outgoing,) = node.step(now_ns, inbox)
    assert isinstance(outgoing[1], OperatorCommand)
    return outgoing[1].u_h[0]
