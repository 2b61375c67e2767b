"""Input sequences: unbroken, and replaced only when the plant cannot follow them."""

import pytest
from passafe_protocol.messages import UNSEQUENCED, PlantInput, PlantPhase, PlantState
from passafe_services.filter.input_sequencer import WAITING_NS, InputSequencer

MS = 1_000_000
WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase


def state(plant_ms: int, phase: PlantPhase, broken_ms: int | None = None) -> PlantState:
    sequence_break_ns = UNSEQUENCED if broken_ms is None else broken_ms * MS
    return PlantState(
        plant_ms * MS, (0.0,), (0.0,), (0.0,), 0, phase, 0.0, 0.0, 0, 0, 0, 0.0, 0, sequence_break_ns=sequence_break_ns
    )


def sequencer_of(repeats: int = 2) -> InputSequencer:
    return InputSequencer(period_ns=MS, hold_ns=10 * MS, repeats=repeats)


def send(sequencer: InputSequencer, *times_ms: int) -> list[PlantInput]:
    return [sequencer.message(at_ms + 1, (float(at_ms), -1.0), at_ms * MS) for at_ms in times_ms]


def test_first_sequence_begins_at_the_scheduled_time() -> None:
    assert sequencer_of().next_input(state(0, WAITING), 3 * MS) == (3 * MS, True)


def test_every_period_gets_one_input_whatever_the_schedule() -> None:
    sequencer = sequencer_of()
    sequencer.next_input(state(0, WAITING), 0)
    send(sequencer, 0, 1)

    assert sequencer.next_input(state(0, RUNNING), 2 * MS) == (2 * MS, False)
    assert sequencer.next_input(state(0, RUNNING), 9 * MS) == (2 * MS, False)  # catches up from where it was
    assert sequencer.next_input(state(0, RUNNING), MS) == (2 * MS, False)  # nothing to make: the next is later


def test_messages_name_their_sequence_and_repeat_previous_inputs() -> None:
    sequencer = sequencer_of(repeats=2)
    sequencer.next_input(state(40, FAIL_SAFE, 31), 50 * MS)
    sent = send(sequencer, 50, 51, 52, 53)

    assert [each.previous_u for each in sent] == [
        (),
        (50.0, -1.0),
        (51.0, -1.0, 50.0, -1.0),
        (52.0, -1.0, 51.0, -1.0),
    ]
    assert {(each.input_sequence_start_ns, each.known_break_ns, each.hold_ns) for each in sent} == {
        (50 * MS, 31 * MS, 10 * MS)
    }
    assert [(each.tick, each.effective_plant_ns) for each in sent] == [(k + 1, k * MS) for k in range(50, 54)]


def test_without_repeats_messages_hold_their_own_input_alone() -> None:
    sequencer = sequencer_of(repeats=0)
    sequencer.next_input(state(0, WAITING), 0)

    assert [each.previous_u for each in send(sequencer, 0, 1)] == [(), ()]


@pytest.mark.parametrize("phase", [HOLDING, FAIL_SAFE])
def test_break_ends_the_sequence_and_the_next_one_names_it(phase: PlantPhase) -> None:
    sequencer = sequencer_of()
    sequencer.next_input(state(0, WAITING), 0)
    send(sequencer, 0, 1, 2, 3)

    assert sequencer.next_input(state(2, phase, 2), 9 * MS) == (9 * MS, True)
    [message] = send(sequencer, 9)
    assert (message.input_sequence_start_ns, message.known_break_ns, message.previous_u) == (9 * MS, 2 * MS, ())


def test_sequence_that_can_still_begin_is_kept() -> None:
    sequencer = sequencer_of()
    sequencer.next_input(state(2, FAIL_SAFE, 2), 9 * MS)
    send(sequencer, 9)

    assert sequencer.next_input(state(8, FAIL_SAFE, 2), 10 * MS) == (10 * MS, False)


@pytest.mark.parametrize("phase", [HOLDING, FAIL_SAFE])
def test_sequence_that_did_not_begin_in_time_ends(phase: PlantPhase) -> None:
    sequencer = sequencer_of()
    sequencer.next_input(state(2, FAIL_SAFE, 2), 9 * MS)
    send(sequencer, 9)

    assert sequencer.next_input(state(9, phase, 2), 20 * MS) == (20 * MS, True)


def test_no_sequence_begins_while_another_filter_drives() -> None:
    sequencer = sequencer_of()

    for plant_ms in range(5):
        next_ns, begins = sequencer.next_input(state(plant_ms, RUNNING, 2), (plant_ms + 6) * MS)
        assert next_ns > (plant_ms + 6) * MS
        assert not begins
    assert sequencer.next_input(state(5, HOLDING, 5), 11 * MS) == (11 * MS, True)
    assert send(sequencer, 11)[0].known_break_ns == 5 * MS


def test_another_filters_sequence_ends_ours() -> None:
    sequencer = sequencer_of()
    sequencer.next_input(state(2, FAIL_SAFE, 2), 9 * MS)
    send(sequencer, 9)

    assert sequencer.next_input(state(20, RUNNING, 15), 25 * MS) == (26 * MS, False)


def test_new_sequence_begins_if_the_first_input_seems_lost() -> None:
    sequencer, last_ms = sequencer_of(), WAITING_NS // MS
    sequencer.next_input(state(0, WAITING), 0)
    send(sequencer, last_ms - 2)
    assert sequencer.next_input(state(0, WAITING), (last_ms - 1) * MS) == ((last_ms - 1) * MS, False)
    send(sequencer, last_ms - 1)

    assert sequencer.next_input(state(0, WAITING), last_ms * MS) == (last_ms * MS, True)


def test_new_sequence_begins_after_a_restart() -> None:
    sequencer = sequencer_of()
    sequencer.next_input(state(0, WAITING), 0)
    send(sequencer, 0, 1)

    sequencer.restart()

    assert sequencer.next_input(state(0, WAITING), 0) == (0, True)
    assert send(sequencer, 0)[0].previous_u == ()
