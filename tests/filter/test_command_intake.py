"""Commands of two sessions and of before and after a stop, at the request that the filter decides from."""

from itertools import pairwise

import pytest
from passafe_protocol.messages import (
    VIRTUAL_CLOCK,
    CommandState,
    Header,
    OperatorCommand,
    PlantPhase,
    PlantState,
    Received,
)
from passafe_protocol.topics import EVENT, LEASE
from passafe_services.filter.build import request_of
from passafe_services.filter.command_events import CommandEventEmitter
from passafe_services.filter.command_intake import CommandIntake
from passafe_services.filter.send_time import SendTime
from passafe_services.scenarios.load import load_scenario

MS = 1_000_000
RESUME_MS = 400
ESTIMATED = {"operator.estimator": {"kind": "white-acceleration", "agility": 100.0, "resolution": 0.1}}


def make_intake(**overrides: object) -> CommandIntake:
    times = {"operator.stale_s": 0.2, "operator.fade_s": 0.1, "operator.resume_s": RESUME_MS / 1e3}
    scenario = load_scenario("notomista-cai-2020", times | overrides)
    return CommandIntake(request_of(scenario, 1, SendTime(VIRTUAL_CLOCK)), CommandEventEmitter(200 * MS, 400 * MS))


def send(intake: CommandIntake, epoch: int, at_ms: int, u: float, *, take_over: int = 0, echoed_ms: int = 0) -> None:
    """Let a command arrive at once."""
    header = Header("operator", epoch, at_ms, at_ms * MS, 0, 0, 0, VIRTUAL_CLOCK)
    echo = (1, echoed_ms * MS) if echoed_ms else (0, 0)
    body = OperatorCommand((u,), (), True, f"d{epoch}", *echo, take_over=take_over)
    intake.receive(Received(header, body, at_ms * MS), body)


def observe(intake: CommandIntake, at_ms: int, *, stop: int = 0, cleared: int = 0) -> bool:
    body = PlantState(
        0, (0.0,), (0.0,), (0.0,), 0, PlantPhase.RUNNING, 0.0, 0.0, 0, 0, 0, 0.0, 0, stop=stop, stops_cleared=cleared
    )
    return intake.observe(Header("plant", 1, at_ms, at_ms * MS, 0, 0, 0), body)


def request(intake: CommandIntake, at_ms: int) -> tuple[float, CommandState]:
    found = intake.at(at_ms * MS)
    return found.u_h[0], found.state


@pytest.mark.parametrize("second", [2, 9], ids=["older", "newer"])
def test_a_second_operator_that_joins_and_quits_changes_nothing(second: int) -> None:
    alone, joined = make_intake(), make_intake()
    for at_ms in range(1, 3_000):
        for intake in (alone, joined):
            send(intake, 5, at_ms, 0.001 * at_ms)
        if 500 < at_ms < 2_000:
            send(joined, second, at_ms, 8.0)
        assert alone.at(at_ms * MS) == joined.at(at_ms * MS)


def test_after_a_take_over_the_request_moves_without_a_jump() -> None:
    """The request is 4 before and -6 after, so the ramp of 400 ms changes it by 1/40 a ms."""
    intake = make_intake()
    found = []
    for at_ms in range(1, 1_200):
        if at_ms < 600:
            send(intake, 5, at_ms, 4.0)
        send(intake, 2, at_ms, -6.0, take_over=1 if at_ms >= 500 else 0)
        found.append(request(intake, at_ms)[0])

    steps = [abs(after - before) for before, after in pairwise(found)]
    assert found[498] == 4.0
    assert max(steps) <= 10 / RESUME_MS + 4 / 100 + 1e-9  # the ramp, and the fade of what was before
    assert found[-1] == -6.0
    assert request(intake, 1_199)[1] is CommandState.COUNTS


def test_reports_carry_the_lease_and_its_events() -> None:
    intake = make_intake()
    send(intake, 5, 1, 0.0)
    assert [topic for topic, _ in intake.reports(MS)] == [LEASE]
    send(intake, 2, 2, 0.0, take_over=1)
    assert [topic for topic, _ in intake.reports(2 * MS)] == [EVENT, LEASE]
    assert intake.reports(3 * MS) == []


@pytest.mark.parametrize("overrides", [{}, ESTIMATED], ids=["as sent", "estimated"])
def test_a_stop_voids_the_request_at_once(overrides: dict[str, object]) -> None:
    intake = make_intake(**overrides)
    for at_ms in range(1, 50):
        send(intake, 5, at_ms, 4.0)
    assert request(intake, 50)[0] == pytest.approx(4.0)

    assert observe(intake, 50, stop=3)

    assert request(intake, 50) == (0.0, CommandState.STOPPED)
    send(intake, 5, 51, 4.0, echoed_ms=51)
    assert request(intake, 51) == (0.0, CommandState.STOPPED)


@pytest.mark.parametrize("overrides", [{}, ESTIMATED], ids=["as sent", "estimated"])
def test_after_the_clear_commands_that_know_of_it_ramp_in(overrides: dict[str, object]) -> None:
    intake = make_intake(**overrides)
    for at_ms in range(1, 50):
        send(intake, 5, at_ms, 4.0)
    observe(intake, 50, stop=3)
    observe(intake, 60, cleared=1)
    found = {}
    for at_ms in range(61, 800):
        send(intake, 5, at_ms, 4.0, echoed_ms=at_ms - 20)  # 20 ms from the plant to the operator
        found[at_ms] = request(intake, at_ms)

    assert {found[at_ms] for at_ms in range(61, 80)} == {(0.0, CommandState.STOPPED)}
    assert found[80] == (0.0, CommandState.RESUMES)
    assert found[80 + RESUME_MS // 4][0] == pytest.approx(1.0)
    assert found[799] == (pytest.approx(4.0), CommandState.COUNTS)


def test_a_clear_that_came_with_its_stop_voids_too() -> None:
    """The filter saw no state of the stop; the command before it must not act on."""
    intake = make_intake()
    send(intake, 5, 40, 4.0)
    observe(intake, 41)

    assert observe(intake, 60, cleared=1)

    assert request(intake, 60) == (0.0, CommandState.STOPPED)


def test_silence_shows_also_after_a_stop() -> None:
    intake = make_intake()
    send(intake, 5, 40, 4.0)
    observe(intake, 50, stop=3)

    assert request(intake, 300)[1] is CommandState.SILENT


def test_restart_forgets_leases_and_stops() -> None:
    intake = make_intake()
    send(intake, 5, 40, 4.0)
    observe(intake, 50, stop=3)
    intake.restart()
    send(intake, 2, 51, 1.0)

    assert request(intake, 51) == (1.0, CommandState.COUNTS)
