"""After an emergency stop commands count that were made knowing of its clear, and no others."""

import pytest
from passafe_protocol.messages import Header, OperatorCommand, PlantPhase, PlantState
from passafe_services.filter.stop_gate import StopGate

PLANT = 40


def observe(gate: StopGate, at: int, *, stop: int = 0, cleared: int = 0, epoch: int = PLANT) -> bool:
    body = PlantState(
        0, (0.0,), (0.0,), (0.0,), 0, PlantPhase.RUNNING, 0.0, 0.0, 0, 0, 0, 0.0, 0, stop=stop, stops_cleared=cleared
    )
    return gate.observe(Header("plant", epoch, at, at, 0, 0, 0), body)


def command(echoed: int | None, *, enabled: bool = True, epoch: int = PLANT) -> OperatorCommand:
    echo = (0, 0) if echoed is None else (epoch, echoed)
    return OperatorCommand((1.0,), (), enabled, "lag", *echo)


def cleared_gate() -> StopGate:
    gate = StopGate()
    observe(gate, 10)
    observe(gate, 20, stop=6)
    observe(gate, 30, cleared=1)
    return gate


def test_it_is_open_until_a_stop() -> None:
    gate = StopGate()

    assert not observe(gate, 10)
    assert gate.pass_on(command(5)) == command(5)
    assert (gate.is_open, gate.is_stopped, gate.cleared) == (True, False, 0)
    assert not gate.opens(command(5))  # it is


def test_a_stop_releases_every_command_and_voids_inputs() -> None:
    gate = StopGate()
    observe(gate, 10)

    assert observe(gate, 20, stop=6)
    assert not observe(gate, 21, stop=6)
    assert not gate.opens(command(25))
    assert gate.pass_on(command(25)) == command(25, enabled=False)
    assert gate.is_stopped


def test_only_a_command_that_saw_the_clear_opens_it() -> None:
    gate = cleared_gate()

    assert not gate.opens(command(29))
    assert not gate.opens(command(35, epoch=PLANT + 1))
    assert not gate.pass_on(command(29)).enabled
    assert gate.opens(command(30))
    assert gate.pass_on(command(30)).enabled
    assert gate.cleared == 1


def test_a_sender_without_echo_lets_go_once() -> None:
    gate = cleared_gate()

    assert not gate.opens(command(None))
    assert gate.opens(command(None, enabled=False))
    assert gate.pass_on(command(None)).enabled


def test_a_stop_of_which_no_state_came_closes_it_too() -> None:
    gate = StopGate()
    observe(gate, 10)

    assert observe(gate, 30, cleared=1)
    assert not gate.opens(command(29))
    assert gate.opens(command(31))


def test_a_filter_started_after_a_clear_asks_for_new_commands() -> None:
    gate = StopGate()

    assert observe(gate, 30, cleared=2)
    assert not gate.opens(command(29))
    assert gate.opens(command(30))


@pytest.mark.parametrize("stop", [0, 7])
def test_another_plant_begins_anew(stop: int) -> None:
    gate = cleared_gate()

    observe(gate, 5, epoch=PLANT + 1, stop=stop)

    assert (gate.is_stopped, gate.is_open, gate.cleared) == (stop != 0, stop == 0, 0)
