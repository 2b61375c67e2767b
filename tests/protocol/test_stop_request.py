"""A press is repeated until a state names it, a clear until none names its stop."""

from passafe_protocol.messages import EmergencyStop, PlantPhase, PlantState, StopClear
from passafe_protocol.stop_request import REPEAT_NS, StopRequest, press_id


def state(stop: int) -> PlantState:
    return PlantState(
        0, (0.0,), (0.0,), (0.0,), 0, PlantPhase.RUNNING, 0.0, 0.0, 0, 0, 0, 0.0, 0, stop=stop, stop_source="x"
    )


def test_a_press_is_repeated_until_a_state_names_it() -> None:
    press = EmergencyStop(5, "smoke")
    request = StopRequest(press)

    assert [request.due(at) for at in (7, 8, 6 + REPEAT_NS, 7 + REPEAT_NS)] == [press, None, None, press]
    request.observe(state(0))
    request.observe(state(4))
    assert not request.is_done
    request.observe(state(5))
    request.observe(state(0))
    assert request.is_done
    assert request.due(9 * REPEAT_NS) is None


def test_a_clear_is_done_when_its_stop_is_no_longer_named() -> None:
    request = StopRequest(StopClear(5, "no smoke"))

    request.observe(state(5))
    assert not request.is_done
    request.observe(state(6))  # somebody pressed again: this clear must not concern it
    request.observe(state(5))
    assert request.is_done


def test_ids_differ_between_presses_and_sessions() -> None:
    ids = {press_id(epoch, number) for epoch in range(1, 40) for number in range(40)}

    assert len(ids) == 39 * 40
    assert 0 not in ids
    assert press_id(0, 0) != 0
    assert all(0 < press_id(2**64 - 1, number) < 2**64 for number in range(5))
