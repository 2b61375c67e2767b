"""The operator node: scripts aligned with plant time, who drives when there are two, what is shown."""

from dataclasses import dataclass
from itertools import count
from math import exp

import pytest
from msgspec.structs import replace
from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    Event,
    FilterStatus,
    FilterTick,
    Header,
    Message,
    OperatorCommand,
    PlantPhase,
    PlantState,
    Received,
)
from passafe_protocol.topics import COMMAND, EVENT, STATE, TICK
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.keyboard.keyboard import RAMP_S, Keyboard
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.node import DISPLAY_PERIOD_NS, DISPLAY_STALE_NS, OperatorNode
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.lag import Lag
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


def command_of(epoch: int, at_ns: int = 0) -> Received:
    return received(OperatorCommand((9.0,), (), True, "other"), at_ns, epoch=epoch, source="operator")


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


def test_step_sends_the_command_of_the_source() -> None:
    node = OperatorNode(Lag(target=(-3.0, 0.0), time_constant_s=0.2), epoch=EPOCH)
    (outgoing,) = node.step(700 * MS, [state(200 * MS, 700 * MS)])
    assert outgoing[0] is COMMAND
    assert isinstance(outgoing[1], OperatorCommand)
    assert outgoing[1].u_h == pytest.approx((-3.0 * (1 - exp(-1)), 0.0))
    assert outgoing[1].u_h_rate == pytest.approx((-15.0 * exp(-1), 0.0))
    assert outgoing[1].enabled
    assert outgoing[1].device == "lag"


def test_a_script_stands_at_its_beginning_until_the_plant_moves() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert asked_for(node, 10 * MS) == 0.0
    assert asked_for(node, 20 * MS, state(0, 15 * MS, PlantPhase.WAITING)) == 0.0
    assert asked_for(node, 900 * MS) == 0.0
    assert asked_for(node, 901 * MS, state(-5 * MS, 901 * MS, PlantPhase.WAITING)) == 0.0


def test_a_script_already_enables_the_robot_while_it_waits() -> None:
    (outgoing,) = OperatorNode(Lag(target=(1.0,), time_constant_s=1.0), epoch=EPOCH).step(0, ())
    assert outgoing[1] == OperatorCommand((0.0,), (1.0,), True, "lag")


@pytest.mark.parametrize("phase", [PlantPhase.RUNNING, PlantPhase.HOLDING, PlantPhase.FAIL_SAFE])
def test_script_time_is_plant_time_plus_the_newest_states_age(phase: PlantPhase) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert asked_for(node, 5_000 * MS, state(120 * MS, 4_998 * MS, phase)) == 0.122
    assert asked_for(node, 5_010 * MS) == 0.132
    assert asked_for(node, 5_011 * MS, state(125 * MS, 5_011 * MS), state(130 * MS, 5_011 * MS)) == 0.13


def test_plant_time_is_exact_to_1_ns_after_long_uptimes() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    uptime_ns = 400 * 86_400 * 10**9
    for index in range(1000):
        plant_ns = 3_600 * 10**9 + index * MS
        assert asked_for(node, uptime_ns + index * MS, state(plant_ns, uptime_ns + index * MS)) == plant_ns / 1e9


def test_reordered_state_does_not_set_the_script_back() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    older, newer = state(100 * MS, 111 * MS), state(110 * MS, 110 * MS)  # numbered in this order
    assert asked_for(node, 111 * MS, newer, older) == 0.111


def test_command_echoes_the_newest_state_and_its_time_here() -> None:
    """The plant's clock is 70 s ahead; a state that was overtaken is not echoed."""
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    body, ahead_ns = state(0, 0).body, 70_000 * MS
    newer, older = (
        Received(Header("plant", 4, number, sent_ms * MS + ahead_ns, 0, 0, 0), body, arrived_ms * MS)
        for number, sent_ms, arrived_ms in ((6, 10, 11), (5, 8, 12))
    )
    echoes = []
    for now_ms, inbox in ((0, []), (20, [newer, older]), (35, [])):
        [(_, sent)] = node.step(now_ms * MS, inbox)
        assert isinstance(sent, OperatorCommand)
        echoes.append((sent.echoed_epoch, sent.echoed_ns, sent.echoed_for_ns))

    assert echoes == [(0, 0, 0), (4, 70_010 * MS, 9 * MS), (4, 70_010 * MS, 24 * MS)]


def test_a_plant_that_starts_again_starts_the_script_again() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert asked_for(node, 100 * MS, state(50 * MS, 100 * MS)) == 0.05
    assert asked_for(node, 200 * MS, state(0, 200 * MS, PlantPhase.WAITING)) == 0.0
    assert asked_for(node, 300 * MS, state(1 * MS, 300 * MS)) == 0.001


def test_same_inbox_gives_same_commands_at_any_start_time() -> None:
    def run(start_ns: int) -> list[object]:
        node = OperatorNode(Lag(target=(-3.0, 1.0), time_constant_s=0.2), epoch=EPOCH)
        inboxes = [[] if k < 5 else [state((k - 5) * MS, start_ns + k * MS)] for k in range(200)]
        commands = [node.step(start_ns + k * MS, inbox)[0][1] for k, inbox in enumerate(inboxes)]
        assert [command.echoed_ns for command in commands[5:]] == [start_ns + k * MS for k in range(5, 200)]
        return [replace(command, echoed_ns=0) for command in commands]

    assert run(0) == run(123_456_789_012_345)


def test_a_person_runs_on_local_time_from_the_first_step() -> None:
    node = OperatorNode(TimeTeller(clock=SourceClock.LOCAL), epoch=EPOCH)
    assert asked_for(node, 7_000 * MS) == 0.0
    assert asked_for(node, 7_250 * MS, state(3 * MS, 7_250 * MS)) == 0.25


def test_observing_source_gets_the_newest_state_first() -> None:
    source = Onlooker()
    node = OperatorNode(source, epoch=EPOCH)
    node.step(0, ())
    node.step(1 * MS, [state(1 * MS, 1 * MS), state(2 * MS, 1 * MS)])
    node.step(2 * MS, ())
    node.step(3 * MS, [command_of(EPOCH), tick(3 * MS, {})])
    node.step(4 * MS, [state(3 * MS, 4 * MS)])

    assert source.seen == [2, 3]
    assert source.seen_when_asked == [0, 1, 1, 1, 2]


def test_reordered_state_is_not_observed() -> None:
    source = Onlooker()
    node = OperatorNode(source, epoch=EPOCH)
    older, newer = state(5 * MS, 7 * MS), state(6 * MS, 6 * MS)  # numbered in this order
    node.step(6 * MS, [newer])
    node.step(7 * MS, [older])

    assert source.seen == [6]


def test_keys_reach_the_wire() -> None:
    keys = [[Key.LEFT]]
    source = Keyboard(authority=10.0, inputs=2, keys=lambda: keys.pop() if keys else [])
    node = OperatorNode(source, epoch=EPOCH)
    node.step(50 * MS, ())
    (outgoing,) = node.step(150 * MS, ())
    body = outgoing[1]
    assert isinstance(body, OperatorCommand)
    assert body.u_h == pytest.approx((-10 * (1 - exp(-0.1 / RAMP_S)), 0.0))
    assert (body.enabled, body.device) == (True, "keyboard")


def test_quitting_sends_a_released_zero_and_tells_the_driver() -> None:
    keys = [[Key.QUIT], [Key.LEFT]]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)
    node.step(0, ())
    assert not node.finished
    (outgoing,) = node.step(MS, ())
    assert outgoing[1] == OperatorCommand((0.0, 0.0), (0.0, 0.0), False, "keyboard")
    assert node.finished


@pytest.mark.parametrize("epoch", [0, EPOCH - 1, EPOCH])
def test_older_and_own_sessions_do_not_silence_a_node(epoch: int) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    for step in range(5):
        (outgoing,) = node.step(step, [command_of(epoch)])
        assert outgoing[0] is COMMAND
    assert not node.superseded


def test_newer_session_silences_a_node_and_is_reported_once() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert node.step(0, ())[0][0] is COMMAND
    (outgoing,) = node.step(1, [command_of(EPOCH + 1)])
    assert outgoing[0] is EVENT
    assert isinstance(outgoing[1], Event)
    assert outgoing[1].severity == "warning"
    assert str(EPOCH + 1) in outgoing[1].text
    assert str(EPOCH) in outgoing[1].text
    assert node.superseded
    for step in range(2, 50):
        inbox = [command_of(EPOCH + 2)] if step % 2 else [command_of(EPOCH)]
        assert list(node.step(step, inbox)) == []


@pytest.mark.parametrize("started_first", [True, False])
def test_of_two_operators_the_later_session_remains(started_first: bool) -> None:
    old, new = OperatorNode(TimeTeller(), epoch=1), OperatorNode(TimeTeller(), epoch=2)
    nodes = {1: old, 2: new} if started_first else {2: new, 1: old}
    inbox: list[Received] = []
    received: list[list[int]] = []
    for step in range(5):
        outbox = [(epoch, out) for epoch, node in nodes.items() for out in node.step(step * MS, inbox)]
        commanding = [epoch for epoch, out in outbox if out[0] is COMMAND]
        received.append(sorted(commanding))
        inbox = [command_of(epoch, step * MS) for epoch in commanding]
    assert received == [[1, 2], [2], [2], [2], [2]]


def test_a_silenced_person_can_still_quit() -> None:
    keys = [[Key.QUIT], [], []]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)
    node.step(0, [command_of(EPOCH + 1)])
    node.step(1, ())
    assert not node.finished
    assert list(node.step(2, ())) == []
    assert node.finished


def test_a_node_reads_filter_ticks_only_for_somebody_to_see() -> None:
    assert OperatorNode(TimeTeller(), epoch=EPOCH).subscribes == (STATE, COMMAND)
    assert OperatorNode(TimeTeller(), epoch=EPOCH, show=lambda _: None).subscribes == (STATE, COMMAND, TICK)


def test_the_display_is_fed_ten_times_a_second_at_most() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    for step in range(1001):
        node.step(step * MS, ())
    assert len(views) == 1000 * MS // DISPLAY_PERIOD_NS + 1


def test_display_shows_position_and_nearest_limit() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    node.step(10 * MS, [state(0, 10 * MS), tick(10 * MS, {"wall": 0.5, "disk": -0.25, "box": 3.0})])
    assert views == [
        OperatorView(
            u_h=(0.0,),
            enabled=True,
            superseded=False,
            position=(1.0,),
            status=FilterStatus.MODIFIED,
            nearest=("disk", -0.25),
        )
    ]


def test_the_display_forgets_what_is_old() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    node.step(0, [state(0, 0), tick(0, {"disk": 1.0})])
    node.step(DISPLAY_STALE_NS, ())
    node.step(DISPLAY_STALE_NS + DISPLAY_PERIOD_NS, ())
    assert [view.position for view in views] == [(1.0,), (1.0,), None]
    assert [view.status is None for view in views] == [False, False, True]
    assert views[2].nearest is None


def test_a_tick_without_barriers_shows_its_status() -> None:
    views: list[OperatorView] = []
    OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append).step(0, [tick(0, {})])
    assert views[0].status is FilterStatus.MODIFIED
    assert views[0].nearest is None


def test_display_shows_a_newer_session() -> None:
    views: list[OperatorView] = []
    OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append).step(0, [command_of(EPOCH + 1)])
    assert views[0].superseded
