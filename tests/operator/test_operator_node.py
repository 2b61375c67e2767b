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
    OperatorLease,
    PlantPhase,
    PlantState,
    Received,
    Steer,
)
from passafe_protocol.topics import COMMAND, EVENT, LEASE, STATE, STEER, STOP, TICK
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.keyboard.keyboard import RAMP_S, Keyboard
from passafe_services.operator.keyboard.keys import Key
from passafe_services.operator.node import DISPLAY_PERIOD_NS, DISPLAY_STALE_NS, OperatorNode
from passafe_services.operator.page.page_driver import PageDriver
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
    node.step(3 * MS, [lease(EPOCH), tick(3 * MS, {})])
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


@pytest.mark.parametrize("holder", [0, EPOCH])
def test_a_free_lease_and_its_own_silence_no_node(holder: int) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    for step in range(5):
        (outgoing,) = node.step(step, [lease(holder)])
        assert outgoing[0] is COMMAND
        assert outgoing[1].take_over == 0


@pytest.mark.parametrize("other", [EPOCH - 1, EPOCH + 1])
def test_the_second_operator_sends_nothing_and_says_so_once(other: int) -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert node.step(0, ())[0][0] is COMMAND

    (outgoing,) = node.step(1, [lease(other)])

    assert outgoing == (
        EVENT,
        Event("warning", f"operator session {EPOCH} sends nothing: session {other} (other) holds the lease"),
    )
    for step in range(2, 50):
        assert list(node.step(step, [lease(other)] if step % 2 else [])) == []


def test_a_waiting_operator_follows_when_the_lease_is_free() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    node.step(0, [lease(7)])

    event, command = node.step(1, [lease(0)])

    assert event == (EVENT, Event("info", f"operator session {EPOCH} waits no longer"))
    assert command[0] is COMMAND
    assert [out[0] for out in node.step(2, [lease(EPOCH)])] == [COMMAND]


def test_a_take_over_names_the_lease_until_it_is_granted() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH, takes_over=True)

    inboxes = [[], [lease(7, number=3)], [], [lease(EPOCH, number=4)], [], [lease(7, number=5)], []]
    sent = [[out[1].take_over for out in node.step(k, inbox) if out[0] is COMMAND] for k, inbox in enumerate(inboxes)]

    assert sent == [[0], [3], [3], [0], [0], [], []]  # asked once: whoever takes over in turn keeps it


def test_a_key_takes_the_lease_over() -> None:
    keys = [[], [Key.TAKE_OVER], [], [Key.TAKE_OVER], []]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)

    sent = [node.step(k, inbox) for k, inbox in enumerate([[], [], [lease(7, number=2)], [], []])]

    requested = [[out[1].take_over for out in outgoing if out[0] is COMMAND] for outgoing in sent]
    assert requested == [[0], [0], [], [2], [2]]


def test_the_stop_is_pressed_until_a_state_names_it() -> None:
    keys = [[], [], [], [], [Key.EMERGENCY_STOP], [Key.LEFT]]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=lambda: keys.pop() if keys else []), epoch=EPOCH)
    node.step(0, ())
    presses = [out[1] for k in range(1, 30) for out in node.step(k * MS, ()) if out[0] is STOP]

    assert len(presses) == 3  # at 1, 11 and 21 ms
    assert len(set(presses)) == 1
    named = stopped(30 * MS, stop=presses[0].id)
    assert [out[0] for k in range(30, 60) for out in node.step(k * MS, [named] if k == 30 else [])] == [COMMAND] * 30


def test_presses_have_ids_of_their_own() -> None:
    keys = [[Key.EMERGENCY_STOP] for _ in range(3)]
    sources = [Keyboard(authority=1.0, inputs=2, keys=lambda: keys[0]) for _ in range(2)]
    nodes = [OperatorNode(source, epoch=epoch) for source, epoch in zip(sources, (EPOCH, 2**64 - 1), strict=True)]
    found = [node.step(k * MS, ())[0][1].id for node in nodes for k in range(3)]

    assert len(set(found)) == 6


def test_a_stop_releases_a_scripts_dead_man_until_the_clear() -> None:
    node = OperatorNode(Lag(target=(-3.0, 0.0), time_constant_s=0.2), epoch=EPOCH)
    inboxes = [[], [stopped(1, stop=5)], [], [stopped(3, stop=0)]]

    sent = [node.step(k, inbox)[-1][1] for k, inbox in enumerate(inboxes)]

    assert [command.enabled for command in sent] == [True, False, False, True]
    assert (sent[1].u_h, sent[1].u_h_rate) == ((0.0, 0.0), (0.0, 0.0))


def test_a_person_lets_go_once_after_a_stop() -> None:
    held = [[Key.LEFT]] * 3 + [[]] * 200 + [[Key.LEFT]]
    node = OperatorNode(Keyboard(authority=9.0, inputs=2, keys=lambda: held.pop(0) if held else []), epoch=EPOCH)
    inboxes = {1: [stopped(1, stop=5)], 2: [stopped(2, stop=0)]}

    enabled = [node.step(k * 10 * MS, inboxes.get(k, []))[-1][1].enabled for k in range(205)]

    assert enabled[0]
    assert not any(enabled[1:203])  # the key counts as held for a while after the clear
    assert enabled[203]


def test_a_silenced_person_can_still_quit() -> None:
    keys = [[Key.QUIT], [], []]
    node = OperatorNode(Keyboard(authority=10.0, inputs=2, keys=keys.pop), epoch=EPOCH)
    node.step(0, [lease(7)])
    node.step(1, ())
    assert not node.finished
    assert list(node.step(2, ())) == []
    assert node.finished


def test_a_node_reads_filter_ticks_only_for_somebody_to_see() -> None:
    assert OperatorNode(TimeTeller(), epoch=EPOCH).subscribes == (STATE, LEASE)
    assert OperatorNode(TimeTeller(), epoch=EPOCH, show=lambda _: None).subscribes == (STATE, LEASE, TICK)


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
            holder="",
            stop_source="",
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


def test_display_shows_who_holds_the_lease_and_who_stopped() -> None:
    views: list[OperatorView] = []
    node = OperatorNode(TimeTeller(), epoch=EPOCH, show=views.append)
    node.step(0, [lease(7)])
    node.step(DISPLAY_PERIOD_NS, [stopped(0, stop=3)])

    assert [(view.holder, view.stop_source) for view in views] == [
        ("session 7 (other)", ""),
        ("session 7 (other)", "console"),
    ]


def steer(
    at_ns: int, driver: str = "page", *, engaged: bool = True, turn: int = 1, take_over: bool = False
) -> Received:
    page = 3 if driver == "page" else 0
    shares = (0.5,) if page else ()
    body = Steer(turn, driver, page, shares, engaged, 0, take_over, EPOCH, at_ns, 0)
    return received(body, at_ns, source="dashboard")


def with_page(clock: SourceClock = SourceClock.PLANT) -> OperatorNode:
    return OperatorNode(TimeTeller(clock=clock), epoch=EPOCH, page=PageDriver((8.0,), epoch=EPOCH))


def sent(node: OperatorNode, now_ns: int, *inbox: Received) -> OperatorCommand:
    [command] = [body for topic, body in node.step(now_ns, inbox) if topic is COMMAND]
    assert isinstance(command, OperatorCommand)
    return command


def test_a_page_takes_the_place_of_the_script_and_hands_back() -> None:
    node = with_page()
    assert STEER in node.subscribes
    assert sent(node, MS, state(5 * MS, MS)).device == "teller"
    assert sent(node, 2 * MS, steer(2 * MS)).enabled
    driven = sent(node, 30 * MS)
    assert (driven.device, driven.enabled) == ("page", True)
    assert 0.0 < driven.u_h[0] < 4.0
    free = sent(node, 31 * MS, steer(31 * MS, "nobody", turn=2))
    assert (free.device, free.enabled, free.u_h) == ("page", False, (0.0,))
    back = sent(node, 35 * MS, steer(35 * MS, "script", turn=3))
    assert (back.device, back.u_h) == ("teller", (pytest.approx(0.039),))


def test_without_a_page_nothing_is_read_of_one() -> None:
    node = OperatorNode(TimeTeller(), epoch=EPOCH)
    assert STEER not in node.subscribes
    assert sent(node, MS, steer(MS)).device == "teller"


def test_a_page_takes_the_lease_over_once() -> None:
    node = with_page()
    assert not [body for topic, body in node.step(MS, [lease(77, number=4)]) if topic is COMMAND]
    assert not [body for topic, body in node.step(2 * MS, [steer(2 * MS)]) if topic is COMMAND]
    assert sent(node, 3 * MS, steer(3 * MS, turn=2, take_over=True)).take_over == 4
    assert sent(node, 4 * MS, lease(EPOCH, number=5)).take_over == 0
    node.step(5 * MS, [lease(77, number=6), steer(5 * MS, turn=2, take_over=True)])
    assert not [body for topic, body in node.step(6 * MS, ()) if topic is COMMAND]


def test_a_page_has_to_let_go_after_an_emergency_stop() -> None:
    node = with_page()
    sent(node, MS, steer(MS))
    assert not sent(node, 2 * MS, stopped(2 * MS, stop=9)).enabled
    assert not sent(node, 3 * MS, stopped(3 * MS, stop=0), steer(3 * MS)).enabled
    assert not sent(node, 4 * MS, steer(4 * MS, engaged=False)).enabled
    assert sent(node, 5 * MS, steer(5 * MS)).enabled
