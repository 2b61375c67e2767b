import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.codec import encode
from passafe_protocol.messages import UNSEQUENCED, Event, Header, PlantInput, PlantPhase, PlantState, Received
from passafe_services.plant.input_check import FAR_NS
from passafe_services.plant.node import PlantNode
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import SampledPlant, damped_point
from passafe.limits import Limits

MS = 1_000_000
X0 = (2.0, 2.0, -1.0, -1.0)
U = (1.0, 0.0)
BOUND = 100.0
WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase


def make_node(*, playout_ns: int = 0, hold_ns: int = 3 * MS, norm: float | None = None) -> PlantNode:
    robot = damped_point(sigma=1.0, gamma_1=10.0)
    limits = Limits.of(2, BOUND, norm)
    return PlantNode(
        SampledPlant(robot.system, robot.system.x.T @ robot.system.x, 1e-3),
        FailSafe(robot, limits, period_ns=MS, hold_ns=hold_ns),
        x0=X0,
        period_ns=MS,
        playout_ns=playout_ns,
        limits=limits,
    )


def head(epoch: int = 1, scheduled_ns: int = 0) -> Header:
    return Header("filter", epoch, 0, scheduled_ns, 0, 0, 0)


def loose(tick: int, due_ms: int, at_ms: int, u: tuple[float, ...] = U, hold_ns: int = 10 * MS) -> Received:
    """Return an unsequenced input."""
    return Received(head(), PlantInput(tick, u, due_ms * MS, hold_ns), at_ms * MS)


def sequenced(
    due_ms: int,
    at_ms: int,
    u: tuple[float, ...] = U,
    *,
    first: int = 0,
    basis: int | None = None,
    previous_u: tuple[float, ...] = (),
    epoch: int = 1,
    term: int = 0,
    made_ms: int = 0,
    hold_ns: int = 10 * MS,
) -> Received:
    """Return an input of the sequence that begins at ``first``, with the tick of its period."""
    known_break_ns = UNSEQUENCED if basis is None else basis * MS
    body = PlantInput(due_ms + 1, u, due_ms * MS, hold_ns, first * MS, known_break_ns, previous_u)
    return Received(head(epoch, made_ms * MS), body, at_ms * MS, term)


def states(node: PlantNode, at_ms: int, *inbox: Received) -> list[PlantState]:
    return [body for _, body in node.step(at_ms * MS, inbox) if isinstance(body, PlantState)]


def test_it_rests_at_x0_until_an_input_comes() -> None:
    node = make_node()

    found = [states(node, k)[0] for k in range(3)]

    assert {state.phase for state in found} == {WAITING}
    assert {(state.plant_ns, state.x, state.sequence_break_ns) for state in found} == {(0, X0, UNSEQUENCED)}


def test_plant_time_begins_one_playout_time_after_first_input() -> None:
    node = make_node(playout_ns=5 * MS)

    assert states(node, 10, sequenced(0, 10))[0].phase is WAITING
    assert states(node, 14)[0].phase is WAITING
    [first] = states(node, 15)
    [second] = states(node, 16)

    assert (first.phase, first.plant_ns, first.u, first.x) == (RUNNING, 0, (1.0, 0.0), X0)
    assert second.plant_ns == MS
    assert first.input_lead_ns == 5 * MS


def test_plant_time_begins_with_the_newest_sequence() -> None:
    node = make_node(playout_ns=5 * MS)
    states(node, 10, sequenced(0, 10))
    assert states(node, 12, sequenced(3000, 12, (2.0, 0.0), first=3000, epoch=2))[0].plant_ns == 3000 * MS

    assert states(node, 16, sequenced(1, 16))[0].phase is WAITING
    [first] = states(node, 17)

    assert (first.phase, first.plant_ns, first.u, first.inputs_refused) == (RUNNING, 3000 * MS, (2.0, 0.0), 1)


def test_first_input_without_effect_leaves_the_plant_at_rest() -> None:
    node = make_node(playout_ns=2 * MS)
    states(node, 1, sequenced(1, 1, previous_u=(float("nan"), 0.0)))

    found = [states(node, k)[-1] for k in range(2, 9)]
    assert {(state.phase, state.plant_ns, state.x) for state in found} == {(WAITING, 0, X0)}
    states(node, 9, sequenced(7, 9, first=7))
    assert states(node, 11)[-1].phase is RUNNING


def test_the_motion_is_the_closed_form_of_the_damped_point() -> None:
    node = make_node()
    states(node, 1, *(sequenced(k, 1, u=(3.0, -1.0)) for k in range(101)))

    state = states(node, 101)[-1]

    t, x1, x2, u = 0.1, np.array([2.0, 2.0]), np.array([-1.0, -1.0]), np.array([3.0, -1.0])
    velocity = u + (x2 - u) * np.exp(-t)
    position = x1 + u * t + (x2 - u) * (1 - np.exp(-t))
    assert state.phase is RUNNING
    assert state.x == pytest.approx([*position, *velocity], abs=1e-12)
    assert state.energy_in_j == pytest.approx(float(u @ (position - x1)), abs=1e-12)
    assert state.energy_stored_j == pytest.approx(float(position @ position + velocity @ velocity), abs=1e-12)


def test_skipped_steps_give_one_state_per_period() -> None:
    node = make_node()
    states(node, 1, *(sequenced(k, 1) for k in range(10)))

    found = states(node, 6)

    assert [state.plant_ns // MS for state in found] == [1, 2, 3, 4, 5]
    assert [state.applied_tick for state in found] == [2, 3, 4, 5, 6]
    assert [state.input_since_ns // MS for state in found] == [1, 2, 3, 4, 5]


def test_missing_input_leads_to_hold_fail_safe_and_new_sequence() -> None:
    node = make_node(hold_ns=3 * MS)
    states(node, 1, sequenced(0, 1), sequenced(1, 1), sequenced(3, 1))

    found = [states(node, 1 + k)[-1] for k in range(1, 4)]
    sent = node.step(5 * MS, ())
    [failed] = [body for _, body in sent if isinstance(body, PlantState)]
    [event] = [body for _, body in sent if isinstance(body, Event)]
    states(node, 6, sequenced(6, 6), sequenced(6, 6, first=6, basis=1), sequenced(6, 6, (0.5, 0.5), first=6, basis=2))
    back = node.step(7 * MS, ())

    assert [state.phase for state in found] == [RUNNING, HOLDING, HOLDING]
    assert [state.sequence_break_ns for state in found] == [UNSEQUENCED, 2 * MS, 2 * MS]
    assert {state.input_since_ns for state in found} == {MS}
    assert (failed.phase, failed.sequence_break_ns) == (FAIL_SAFE, 2 * MS)
    assert failed.u == pytest.approx([-9.0 * value for value in failed.x[2:]])
    assert "fail-safe" in event.text
    [state] = [body for _, body in back if isinstance(body, PlantState)]
    assert (state.phase, state.u, state.inputs_refused) == (RUNNING, (0.5, 0.5), 2)
    assert ["released" in body.text for _, body in back if isinstance(body, Event)] == [True]


@pytest.mark.parametrize(("hold_ns", "held"), [(0, 0), (MS, 0), (2 * MS, 1), (2 * MS + 1, 1), (5 * MS, 4), (9 * MS, 4)])
def test_an_input_may_ask_for_a_shorter_hold_than_the_plants(hold_ns: int, held: int) -> None:
    node = make_node(hold_ns=5 * MS)
    states(node, 1, sequenced(0, 1, hold_ns=hold_ns))
    phases = [states(node, 1 + k)[-1].phase for k in range(1, 8)]

    assert phases == [HOLDING] * held + [FAIL_SAFE] * (7 - held)


def test_broken_sequence_stays_broken_whatever_arrives_later() -> None:
    node = make_node(hold_ns=2 * MS)
    states(node, 1, sequenced(0, 1))
    states(node, 2)

    found = [states(node, at_ms, sequenced(at_ms - 2, at_ms), sequenced(at_ms + 3, at_ms))[-1] for at_ms in range(3, 9)]

    assert {state.sequence_break_ns for state in found} == {MS}
    assert {state.phase for state in found} == {FAIL_SAFE}
    assert [state.inputs_refused for state in found] == [2, 4, 6, 8, 10, 12]
    assert [state.inputs_late for state in found] == [1, 2, 3, 4, 5, 6]


def test_lost_message_repeated_in_time_breaks_nothing() -> None:
    node = make_node()
    states(node, 1, sequenced(0, 1), sequenced(3, 1, (4.0, 4.0), previous_u=(3.0, 3.0, 2.0, 2.0)))

    found = [states(node, k)[-1] for k in range(2, 6)]

    assert [(state.phase, state.u) for state in found] == [
        (RUNNING, (2.0, 2.0)),
        (RUNNING, (3.0, 3.0)),
        (RUNNING, (4.0, 4.0)),
        (HOLDING, (4.0, 4.0)),
    ]
    assert [state.applied_tick for state in found] == [2, 3, 4, 4]


@pytest.mark.parametrize(
    "u",
    [
        (float("nan"), 0.0),
        (float("inf"), 0.0),
        (BOUND + 1.0, 0.0),
        (0.0,),
        (0.0, 0.0, 0.0),
        (),
    ],
)
def test_an_input_that_cannot_be_applied_is_refused_and_counted(u: tuple[float, ...]) -> None:
    node = make_node()

    state = states(node, 1, sequenced(0, 1, u))[-1]

    assert (state.phase, state.inputs_refused, state.input_epoch) == (WAITING, 1, 0)


@pytest.mark.parametrize("u", [(3.0, 4.1), (-5.2, 0.0)])
def test_repeated_inputs_beyond_the_norm_are_refused_too(u: tuple[float, ...]) -> None:
    node = make_node(norm=5.0)
    states(node, 1, sequenced(0, 1, (3.0, 4.0)), sequenced(2, 1, (3.0, -4.0), previous_u=(*u, 0.0, 0.0)))

    assert states(node, 1, sequenced(1, 1, u))[-1].inputs_refused == 1
    assert states(node, 2)[-1].phase is HOLDING


@pytest.mark.parametrize("previous_u", [(1.0,), (1.0, 2.0, 3.0)])
def test_repeats_of_the_wrong_shape_are_refused(previous_u: tuple[float, ...]) -> None:
    assert states(make_node(), 1, sequenced(1, 1, previous_u=previous_u))[-1].inputs_refused == 1


@pytest.mark.parametrize(
    ("body", "scheduled_ns"),
    [
        (PlantInput(1, U, FAR_NS + 1, 0, (FAR_NS + 1) % MS), 0),
        (PlantInput(1, U, -1, 0, 0), 0),  # plant time is never negative: −1 stands for none
        (PlantInput(1, U, 0, 0, 0), FAR_NS + 1),
        (PlantInput(1, U, 0, 0, 0), -FAR_NS - 1),
        (PlantInput(1, U, 2 * MS, 0, 0, UNSEQUENCED, (0.0,) * 4), 0),  # repeats inputs of ticks before the first
    ],
)
def test_numbers_that_no_filter_has_are_refused(body: PlantInput, scheduled_ns: int) -> None:
    state = states(make_node(), 1, Received(head(1, scheduled_ns), body, MS))[-1]

    assert (state.phase, state.inputs_refused) == (WAITING, 1)


def test_session_of_an_earlier_term_is_refused() -> None:
    node = make_node()
    states(node, 1, *(sequenced(due_ms, 1, epoch=9, term=3) for due_ms in (0, 1, 3)))
    still = states(node, 2, sequenced(20, 2, first=20, epoch=2, term=4))[-1]

    state = states(node, 3, sequenced(2, 3, epoch=9, term=3))[-1]

    assert (still.phase, still.inputs_refused, still.input_epoch) == (RUNNING, 1, 2)
    assert (state.phase, state.inputs_refused, state.input_epoch) == (HOLDING, 2, 2)


def test_state_reports_the_largest_transit_time() -> None:
    node = make_node(playout_ns=5 * MS)
    states(node, 10, sequenced(0, 10, made_ms=1007))  # plant time of the arrival: −5 ms
    assert states(node, 11)[-1].input_transit_ns == (-5 - 1007) * MS

    states(node, 13, sequenced(1, 13, made_ms=1008))

    state = states(node, 14, sequenced(2, 14, made_ms=1012))[-1]
    assert (state.input_transit_ns, state.input_epoch) == (-2 * MS - 1008 * MS, 1)


def test_inputs_that_waited_for_a_suspended_plant_are_no_transit() -> None:
    node = make_node()
    states(node, 1, sequenced(0, 1, made_ms=-4))
    [before] = states(node, 2, sequenced(1, 2, made_ms=-3))

    waited = [sequenced(k, 2_002, made_ms=k - 4, first=1_900) for k in range(1_900, 1_910)]
    resumed = states(node, 2_002, *waited)[-1]
    soon = states(node, 2_010, sequenced(1_950, 2_010, made_ms=1_000))[-1]
    later = states(node, 2_060, sequenced(2_059, 2_060, made_ms=2_052))[-1]

    assert before.input_transit_ns == resumed.input_transit_ns == soon.input_transit_ns == 4 * MS
    assert later.input_transit_ns == 7 * MS
    assert resumed.plant_ns == 2_001 * MS


def test_a_plant_that_waits_is_not_suspended() -> None:
    node = make_node()
    states(node, 0)
    states(node, 5_000, sequenced(0, 5_000, made_ms=4_990))

    assert states(node, 5_001, sequenced(1, 5_001, made_ms=4_989))[-1].input_transit_ns == -4_988 * MS


def test_lost_input_counts_as_arrived_with_its_repetition() -> None:
    node = make_node(playout_ns=5 * MS)
    states(node, 10, sequenced(0, 10, made_ms=10))
    states(node, 13, sequenced(3, 13, made_ms=13, previous_u=(3.0, 3.0, 2.0, 2.0)))

    assert states(node, 14)[-1].input_transit_ns == (-2 - 13 + 2) * MS


def test_break_transit_counts_for_the_first_repetition_alone() -> None:
    node = make_node()
    states(node, 10, sequenced(0, 10, made_ms=10))
    states(node, 12)
    first = states(node, 13, sequenced(3, 13, made_ms=13, previous_u=(3.0, 3.0, 2.0, 2.0)))[-1]
    second = states(node, 14, sequenced(4, 14, made_ms=14, previous_u=(4.0, 4.0, 3.0, 3.0, 2.0, 2.0)))[-1]

    assert (first.sequence_break_ns, first.input_transit_ns) == (MS, (3 - 13 + 2) * MS)
    assert second.input_transit_ns == first.input_transit_ns


def test_an_unsequenced_input_is_refused() -> None:
    node = make_node()

    resting = states(node, 1, loose(1, 0, 1))[-1]
    states(node, 2, sequenced(0, 2), sequenced(1, 2))
    running = states(node, 3, loose(9, 1, 3, u=(9.0, 9.0)))[-1]

    assert (resting.phase, resting.inputs_refused, resting.input_epoch) == (WAITING, 1, 0)
    assert (running.phase, running.u, running.inputs_refused) == (RUNNING, U, 2)


number = st.one_of(st.floats(-120, 120), st.sampled_from([float("nan"), float("inf"), BOUND, -BOUND]))
vector = st.lists(number, max_size=5).map(tuple)
pair = st.tuples(st.floats(-BOUND, BOUND), st.floats(-BOUND, BOUND))
time_ns = st.one_of(
    st.integers(-3, 25).map(lambda k: k * MS), st.sampled_from([UNSEQUENCED, MS + 1, -(2**63), 2**63 - 1])
)
plant_input = st.builds(
    PlantInput,
    tick=st.one_of(st.integers(0, 40), st.just(2**64 - 1)),
    u=st.one_of(pair, vector),
    effective_plant_ns=time_ns,
    hold_ns=st.sampled_from([0, MS, 2**64 - 1]),
    input_sequence_start_ns=time_ns.filter(lambda ns: ns >= UNSEQUENCED),
    known_break_ns=time_ns.filter(lambda ns: ns >= UNSEQUENCED),
    previous_u=st.one_of(vector, st.lists(pair, max_size=6).map(lambda pairs: sum(pairs, ()))),
)


@settings(max_examples=60)
@given(
    st.lists(
        st.tuples(st.integers(0, 3), st.lists(st.tuples(st.integers(1, 3), time_ns, plant_input), max_size=4)),
        max_size=25,
    )
)
def test_any_messages_keep_inputs_bounded_and_states_valid(
    steps: list[tuple[int, list[tuple[int, int, PlantInput]]]],
) -> None:
    node, at_ms = fuzzed(), 1
    for skipped, bodies in steps:
        at_ms += 1 + skipped
        inbox = [Received(head(epoch, made_ns), body, at_ms * MS) for epoch, made_ns, body in bodies]
        for state in states(node, at_ms, *inbox):
            assert all(-BOUND <= value <= BOUND for value in state.u)
            assert len(state.u) == 2
            assert np.isfinite(state.x).all()
            assert encode(head(), state)
        assert len(node._inputs._pending) <= 7 * len(steps) * 4


@settings(max_examples=40)
@given(st.data())
def test_running_sequence_applies_its_inputs_in_order(data: st.DataObject) -> None:
    """Sequences of two filters, lost, late, overtaken and repeated: u encodes sequence and period of an input."""
    node, sequences, broken_ns = fuzzed(), [(0, None)], UNSEQUENCED
    before: PlantState | None = None
    for at_ms in range(1, 40):
        inbox = []
        for _ in range(data.draw(st.integers(0, 3))):
            which = data.draw(st.integers(0, len(sequences) - 1))
            first, basis = sequences[which]
            due = first + data.draw(st.integers(0, 12))
            count = data.draw(st.integers(0, min(due - first, 4)))
            previous_u = sum(((float(which), float(due - i)) for i in range(1, count + 1)), ())
            u = (float(which), float(due))
            inbox.append(sequenced(due, at_ms, u, first=first, basis=basis, previous_u=previous_u, epoch=1 + which % 2))
        for state in states(node, at_ms, *inbox):
            if state.phase is RUNNING:
                which = int(state.u[0])
                assert state.u[1] * MS == state.plant_ns
                if before is None or before.phase is not RUNNING:
                    assert sequences[which][0] * MS == state.plant_ns
                elif state.plant_ns > before.plant_ns:
                    assert state.u == (before.u[0], before.u[1] + 1.0)
                if sequences[which][1] is not None:
                    assert sequences[which][1] * MS == state.sequence_break_ns
            if state.sequence_break_ns != broken_ns:
                broken_ns = state.sequence_break_ns
                now = state.plant_ns // MS
                sequences += [(now + ahead, broken_ns // MS) for ahead in (2, 3)]
            before = state if state.phase is not WAITING else None


def fuzzed() -> PlantNode:
    """Return a fresh node of a robot that is compiled once."""
    return PlantNode(PLANT, RULE, x0=X0, period_ns=MS, playout_ns=0, limits=Limits.of(2, BOUND))


ROBOT = damped_point(sigma=1.0, gamma_1=10.0)
PLANT = SampledPlant(ROBOT.system, ROBOT.system.x.T @ ROBOT.system.x, 1e-3)
RULE = FailSafe(ROBOT, Limits.of(2, BOUND), period_ns=MS, hold_ns=2 * MS)
