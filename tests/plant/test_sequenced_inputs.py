"""Input sequences at the plant: applied without gaps, at their times, for the break from which they were predicted."""

from itertools import count

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from passafe_protocol.messages import UNSEQUENCED, PlantInput
from passafe_services.plant.sequenced_inputs import MOST_AHEAD, NOTHING_NEW, REFUSED, SequencedInput, SequencedInputs

MS = 1_000_000


def is_applicable(u: tuple[float, ...]) -> bool:
    return all(-100.0 <= value <= 100.0 for value in u)


def sequenced_inputs() -> SequencedInputs:
    return SequencedInputs(MS, is_applicable)


def value(due: int, first: int = 0, basis: int = UNSEQUENCED) -> float:
    """Return the input of a sequence for a period, encoding which one it is."""
    return due + first * 1e-3 + basis * 1e-6


def put(
    held: SequencedInputs,
    due: int,
    *,
    first: int = 0,
    basis: int = UNSEQUENCED,
    repeats: int = 0,
    term: int = 1,
    previous_u: tuple[float, ...] | None = None,
) -> int:
    """Put in the message of one period with what it repeats; times in periods."""
    if previous_u is None:
        previous_u = tuple(value(due - i, first, basis) for i in range(1, min(repeats, due - first) + 1))
    known_break_ns = UNSEQUENCED if basis == UNSEQUENCED else basis * MS
    body = PlantInput(due + 1, (value(due, first, basis),), due * MS, 5 * MS, first * MS, known_break_ns, previous_u)
    return held.receive(term, body)


def take(held: SequencedInputs, *periods: int) -> list[float | None]:
    """Return the inputs that take effect at some plant times."""
    taken = [held.pop_due(period * MS) for period in periods]
    return [None if each is None else each.u[0] for each in taken]


def test_sequence_takes_effect_period_by_period() -> None:
    held = sequenced_inputs()
    admissions = [put(held, due) for due in range(4)]

    assert admissions == [0] * 4
    assert take(held, *range(4)) == [value(due) for due in range(4)]
    assert (held.is_running, held.sequence_break_ns) == (True, UNSEQUENCED)


def test_due_input_has_its_tick_and_hold_time() -> None:
    held = sequenced_inputs()
    put(held, 2, repeats=2)

    assert [held.pop_due(k * MS) for k in range(3)] == [SequencedInput((value(k),), k + 1, 5 * MS) for k in range(3)]


def test_missing_input_breaks_the_sequence_and_voids_the_rest() -> None:
    held = sequenced_inputs()
    for due in (0, 1, 3, 4):
        put(held, due)

    assert take(held, *range(5)) == [value(0), value(1), None, None, None]
    assert (held.is_running, held.sequence_break_ns, held.first_ns) == (False, 2 * MS, UNSEQUENCED)
    assert held._pending == {}
    assert put(held, 5) == REFUSED


def test_only_a_sequence_that_knows_the_break_begins() -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1)

    assert held.sequence_break_ns == MS
    assert put(held, 5, first=5) == REFUSED
    assert put(held, 5, first=5, basis=2) == REFUSED
    assert put(held, 5, first=5, basis=1) == 0
    assert take(held, 2, 3, 4, 5, 6) == [None, None, None, value(5, 5, 1), None]
    assert held.sequence_break_ns == 6 * MS


@pytest.mark.parametrize(("due", "expected"), [(4, REFUSED), (5, REFUSED), (6, 0)])
def test_the_first_input_has_to_come_before_its_time(due: int, expected: int) -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, *range(6))

    assert put(held, due, first=due, basis=1) == expected


def test_sequence_with_a_late_first_input_never_starts() -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1)
    put(held, 4, first=3, basis=1)
    put(held, 5, first=3, basis=1)

    assert take(held, 2, 3) == [None, None]
    assert put(held, 3, first=3, basis=1) == REFUSED
    assert take(held, 4, 5) == [None, None]
    assert held.sequence_break_ns == MS


@pytest.mark.parametrize("lost", range(1, 6))
def test_repeats_fill_holes_up_to_their_number(lost: int) -> None:
    held, repeats = sequenced_inputs(), 3
    put(held, 0)
    due = lost + 1
    admission = put(held, due, repeats=repeats)
    taken = take(held, *range(due + 1))

    assert admission == min(lost, repeats)
    if lost <= repeats:
        assert taken == [value(k) for k in range(due + 1)]
    else:
        assert taken == [value(0)] + [None] * due
        assert held.sequence_break_ns == MS


def test_repeats_reach_back_to_the_first_input_and_no_further() -> None:
    held = sequenced_inputs()

    assert put(held, 7, first=5, previous_u=(1.0, 2.0, 3.0, 4.0)) == 2
    assert take(held, 5, 6, 7) == [2.0, 1.0, value(7, 5)]


def test_first_message_must_contain_the_first_input() -> None:
    held = sequenced_inputs()

    assert put(held, 3, repeats=2) == REFUSED
    assert put(held, 3, repeats=3) == 3
    assert held.first_ns == 0


@given(st.permutations(range(12)), st.integers(0, 3))
def test_the_order_of_arrival_does_not_matter(order: list[int], repeats: int) -> None:
    held = sequenced_inputs()
    put(held, 0)
    for due in order:
        put(held, due, repeats=repeats)
        put(held, due, repeats=repeats)

    assert take(held, *range(13)) == [*map(value, range(12)), None]


def test_what_is_known_or_has_passed_is_repetition() -> None:
    held = sequenced_inputs()
    put(held, 0)
    assert put(held, 0) == NOTHING_NEW
    take(held, 0)

    assert put(held, 0) == NOTHING_NEW
    assert put(held, 1) == 0


def test_a_known_input_is_not_replaced() -> None:
    held = sequenced_inputs()
    put(held, 1, previous_u=(40.0,))
    put(held, 2, previous_u=(41.0, 42.0))

    assert take(held, 0, 1, 2) == [40.0, value(1), value(2)]


def test_running_sequence_refuses_other_sequences() -> None:
    held = sequenced_inputs()
    put(held, 0)
    put(held, 1)
    take(held, 0)

    assert put(held, 1, first=1) == REFUSED
    assert put(held, 1, first=1, term=2) == REFUSED
    assert put(held, 1, term=2) == REFUSED
    assert take(held, 1) == [value(1)]


def test_newer_of_two_pending_sequences_wins() -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1)
    put(held, 5, first=5, basis=1)
    put(held, 6, first=5, basis=1)

    assert put(held, 6, first=6, basis=1) == 0
    assert put(held, 7, first=5, basis=1) == REFUSED
    assert take(held, 2, 3, 4, 5, 6, 7) == [None] * 4 + [value(6, 6, 1), None]


def test_newer_session_wins_whenever_its_sequence_begins() -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1)
    put(held, 9, first=9, basis=1, term=1)

    assert put(held, 5, first=5, basis=1, term=2) == 0
    assert put(held, 8, first=8, basis=1, term=1) == REFUSED
    assert take(held, *range(2, 6)) == [None] * 3 + [value(5, 5, 1)]


def test_newer_sequence_replaces_one_that_has_not_started() -> None:
    held = sequenced_inputs()
    put(held, 0)
    put(held, 1)

    assert put(held, 3000, first=3000) == 0
    assert held.first_ns == 3000 * MS
    assert put(held, 2) == REFUSED
    assert take(held, 3000, 3001) == [value(3000, 3000), None]


def test_inputs_too_far_ahead_are_refused_without_side_effects() -> None:
    held = sequenced_inputs()
    put(held, 0)
    assert put(held, MOST_AHEAD) == 0
    assert put(held, MOST_AHEAD + 1) == REFUSED
    take(held, 0, 1)
    put(held, 5, first=5, basis=1)

    assert put(held, 2 + MOST_AHEAD, first=2 + MOST_AHEAD, basis=1) == REFUSED
    assert put(held, 10**9, first=5, basis=1) == REFUSED
    assert take(held, 2, 3, 4, 5) == [None] * 3 + [value(5, 5, 1)]


@pytest.mark.parametrize(("due_ns", "first_ns"), [(MS, 2 * MS), (5 * MS + 1, 5 * MS), (5 * MS + 1, 5 * MS + 1)])
def test_times_off_the_grid_or_before_the_first_are_refused(due_ns: int, first_ns: int) -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1)
    body = PlantInput(1, (1.0,), due_ns, 0, first_ns, MS)

    assert held.receive(1, body) == REFUSED
    assert held.first_ns == UNSEQUENCED


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), 100.5])
def test_a_repeated_input_that_cannot_be_applied_is_a_hole(bad: float) -> None:
    held = sequenced_inputs()
    put(held, 0)

    assert put(held, 3, previous_u=(value(2), bad)) == 1
    assert take(held, *range(4)) == [value(0), None, None, None]


def missed(held: SequencedInputs, due: int, *, repeats: int, first: int = 0, basis: int = UNSEQUENCED) -> int:
    previous_u = (0.0,) * min(repeats, due - first)
    known_break_ns = UNSEQUENCED if basis == UNSEQUENCED else basis * MS
    body = PlantInput(due + 1, (0.0,), due * MS, 0, first * MS, known_break_ns, previous_u)
    assert held.receive(1, body) == REFUSED
    return held.periods_late(1, body)


def test_first_repetition_of_a_missing_input_gives_its_lateness() -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1, 2, 3)

    assert missed(held, 6, repeats=4) == 0  # does not reach back to 1
    assert missed(held, 5, repeats=4) == 4
    assert missed(held, 4, repeats=4) == 0  # reported already
    assert missed(held, 3, repeats=0) == 0


def test_so_it_is_for_a_first_input_that_did_not_come() -> None:
    held = sequenced_inputs()
    put(held, 0)
    take(held, 0, 1, 2, 3, 4)

    assert missed(held, 5, repeats=4, first=3, basis=2) == 0  # rests on something else
    assert missed(held, 5, repeats=4, first=3, basis=1) == 2
    assert missed(held, 6, repeats=4, first=3, basis=1) == 0


@settings(max_examples=30)
@given(st.data())
def test_no_input_takes_effect_outside_its_sequence(data: st.DataObject) -> None:
    """Any messages of filters that play by the rule, in any order: each input that is taken follows the one before."""
    held = sequenced_inputs()
    due_of = st.integers(0, 30)
    before: float | None = None
    for now in count():
        if now == 30:
            break
        for _ in range(data.draw(st.integers(0, 4))):
            due, first = data.draw(due_of), data.draw(due_of)
            basis = data.draw(st.sampled_from([UNSEQUENCED, max(held.sequence_break_ns, -MS) // MS, 3]))
            repeats = data.draw(st.integers(0, 5))
            if first <= due:
                put(held, due, first=first, basis=basis, repeats=repeats, term=data.draw(st.integers(1, 2)))
        waiting = held.sequence_break_ns // MS if held.sequence_break_ns >= 0 else UNSEQUENCED
        [taken] = take(held, now)
        if taken is not None:
            sequence = round((taken - now) * 1e6)
            if before is not None:
                assert sequence == before
            else:
                assert sequence == round((value(now, now, waiting) - now) * 1e6)
            before = sequence
        else:
            before = None
        assert len(held._pending) <= 60
