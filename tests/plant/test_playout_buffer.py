from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol.messages import PlantInput
from passafe_services.plant.playout_buffer import MOST_PENDING, PlayoutBuffer


def plant_input(tick: int, due_ns: int) -> PlantInput:
    return PlantInput(tick, (float(tick),), due_ns, 0)


def test_an_input_waits_for_its_time_and_comes_out_once() -> None:
    buffer = PlayoutBuffer(1)
    buffer.put(plant_input(1, 2))

    assert [buffer.pop_due(time) for time in (0, 1)] == [None, None]
    assert buffer.pop_due(2) == plant_input(1, 2)
    assert buffer.pop_due(3) is None


def test_newer_tick_wins_for_the_same_time_in_either_order() -> None:
    for ticks in ((1, 2), (2, 1)):
        buffer = PlayoutBuffer(1)
        for tick in ticks:
            buffer.put(plant_input(tick, 5))
        assert buffer.pop_due(5) == plant_input(2, 5)


def test_newest_late_input_is_returned_and_the_others_removed() -> None:
    buffer = PlayoutBuffer(1)
    for tick, due_ns in ((1, 1), (3, 3), (2, 2), (9, 6)):
        buffer.put(plant_input(tick, due_ns))

    assert buffer.pop_due(4) == plant_input(3, 3)
    buffer.put(plant_input(5, 1))
    buffer.put(plant_input(4, 4))
    assert buffer.pop_due(5) == plant_input(5, 1)
    assert buffer.pop_due(6) == plant_input(9, 6)


def test_effective_time_is_rounded_up_to_the_next_period() -> None:
    buffer = PlayoutBuffer(10)
    buffer.put(plant_input(1, 11))

    assert [buffer.pop_due(time) for time in (0, 10, 20)] == [None, None, plant_input(1, 11)]


def test_a_full_buffer_refuses_more() -> None:
    buffer = PlayoutBuffer(1)

    kept = [buffer.put(plant_input(k, 10 + k)) for k in range(MOST_PENDING + 5)]

    assert kept == [True] * MOST_PENDING + [False] * 5


@given(st.lists(st.tuples(st.integers(1, 50), st.integers(0, 50)), max_size=40))
def test_what_comes_out_is_never_early_and_nothing_stays_behind(inputs: list[tuple[int, int]]) -> None:
    buffer = PlayoutBuffer(1)
    for tick, due_ns in inputs:
        buffer.put(plant_input(tick, due_ns))

    taken = [(time, buffer.pop_due(time)) for time in range(51)]

    assert all(found.effective_plant_ns <= time for time, found in taken if found is not None)
    assert buffer.pop_due(51) is None
