"""Request of the operator, passed through and estimated."""

import pytest
from passafe_protocol.messages import VIRTUAL_CLOCK, Header, OperatorCommand, Received
from passafe_services.filter.dead_man import DeadManFade
from passafe_services.filter.newest_command import NewestCommand
from passafe_services.filter.operator_request import EstimatedRequest, PassThroughRequest
from passafe_services.filter.resume_ramp import ResumeRamp
from passafe_services.filter.send_time import SendTime
from passafe_services.filter.sender_clock import SenderClock

from passafe.human_input import HandModel, HumanInputEstimator

MS = 1_000_000
STALE_NS = 200 * MS
FADE_NS = 100 * MS
RESUME_NS = 400 * MS
CLOCK_AHEAD_NS = 77_000_000 * MS
ZERO = ((0.0,), (0.0,))


def parts(fade_ns: int) -> tuple[NewestCommand, DeadManFade, ResumeRamp]:
    ramp = ResumeRamp(DeadManFade(1, fade_ns), RESUME_NS)
    return NewestCommand(SendTime(VIRTUAL_CLOCK), STALE_NS), DeadManFade(1, fade_ns), ramp


def pass_through(fade_ns: int = FADE_NS) -> PassThroughRequest:
    return PassThroughRequest(1, *parts(fade_ns))


def estimated() -> EstimatedRequest:
    model = HandModel(agility=10.0, resolution=2 / 64, horizon_s=0.05, fade_s=0.1)
    return EstimatedRequest(1, *parts(FADE_NS), HumanInputEstimator(model, 1))


def seen(request: PassThroughRequest, now_ns: int) -> tuple[tuple[float, ...], tuple[float, ...], int, bool]:
    """Return what is requested at a tick, without the reason."""
    found = request.at(now_ns)
    return found.u_h, found.u_h_rate, found.age_ns, found.is_stale


def receive(
    request: PassThroughRequest,
    at_ms: float,
    u_h: tuple[float, ...],
    *,
    late_ms: float = 0,
    enabled: bool = True,
    epoch: int = 1,
    number: int | None = None,
    rate: tuple[float, ...] = (),
) -> None:
    scheduled_ns = CLOCK_AHEAD_NS + round(at_ms * MS)
    header = Header("operator", epoch, round(at_ms) if number is None else number, scheduled_ns, 0, 0, 0)
    body = OperatorCommand(u_h, rate, enabled, "test")
    request.receive(Received(header, body, round((at_ms + late_ms) * MS)), body)


def ramp(request: PassThroughRequest, first_ms: int = 0, last_ms: int = 500) -> None:
    for at_ms in range(first_ms, last_ms + 1, 20):
        receive(request, at_ms, (at_ms * 1e-3,))


@pytest.mark.parametrize("make", [pass_through, estimated])
def test_without_a_command_it_is_zero_and_stale(make: type) -> None:
    assert seen(make(), 5 * MS) == (*ZERO, -1, True)


@pytest.mark.parametrize("make", [pass_through, estimated])
def test_stale_command_fades_linearly_to_zero(make: type) -> None:
    request = make()
    ramp(request)

    (last,), _, *rest = seen(request, 700 * MS)

    assert rest == [200 * MS, False]
    assert 0.5 <= last <= 0.601
    for age_ms in (201, 220, 260, 299):
        share = (300 - age_ms) / 100
        (u_h,), (rate,), age_ns, stale = seen(request, (500 + age_ms) * MS)
        assert (u_h, rate) == (pytest.approx(share * last, abs=1e-12), pytest.approx(-last / 0.1, rel=1e-12))
        assert (age_ns, stale) == (age_ms * MS, True)
    assert seen(request, 800 * MS) == (*ZERO, 300 * MS, True)
    assert seen(request, 9_000 * MS)[:2] == ZERO


@pytest.mark.parametrize("make", [pass_through, estimated])
def test_a_released_dead_man_fades_and_is_not_stale(make: type) -> None:
    request = make()
    ramp(request)
    (last,), *_ = seen(request, 510 * MS)
    for at_ms in range(520, 700, 20):  # a device says it again and again
        receive(request, at_ms, (3.0,), enabled=False)

    assert seen(request, 520 * MS)[0] == (last,)
    assert seen(request, 570 * MS) == ((pytest.approx(last / 2),), (pytest.approx(-last / 0.1),), 0, False)
    assert seen(request, 620 * MS)[:2] == ZERO
    assert seen(request, 690 * MS) == (*ZERO, 10 * MS, False)


def test_release_of_a_stale_command_does_not_restart_the_fade() -> None:
    request = pass_through()
    receive(request, 0, (1.0,))
    seen(request, 200 * MS)
    receive(request, 250, (1.0,), enabled=False)

    assert seen(request, 260 * MS)[0] == (pytest.approx(0.4),)
    assert seen(request, 300 * MS)[:2] == ZERO


def test_a_dead_man_that_is_pressed_again_counts_at_once() -> None:
    request = pass_through()
    receive(request, 0, (1.0,))
    seen(request, 0)
    receive(request, 10, (1.0,), enabled=False)
    seen(request, 50 * MS)
    receive(request, 60, (2.0,))

    assert seen(request, 60 * MS) == ((2.0,), (0.0,), 0, False)


def test_unpressed_dead_man_requests_nothing() -> None:
    request = pass_through()
    receive(request, 0, (1.0,), enabled=False)

    assert seen(request, 10 * MS) == (*ZERO, 10 * MS, False)


def test_without_a_time_to_fade_it_is_zero_at_once() -> None:
    request = pass_through(fade_ns=0)
    receive(request, 0, (1.0,))
    seen(request, 200 * MS)

    assert seen(request, 201 * MS) == (*ZERO, 201 * MS, True)
    receive(request, 210, (1.0,))
    seen(request, 210 * MS)
    receive(request, 220, (1.0,), enabled=False)
    assert seen(request, 220 * MS) == (*ZERO, 0, False)


@pytest.mark.parametrize("make", [pass_through, estimated])
def test_restart_discards_all_commands(make: type) -> None:
    request = make()
    ramp(request)
    seen(request, 500 * MS)

    request.restart()

    assert seen(request, 510 * MS) == (*ZERO, -1, True)
    receive(request, 0, (0.25,))
    assert seen(request, 10 * MS) == ((0.25,), (0.0,), 10 * MS, False)


@pytest.mark.parametrize("make", [pass_through, estimated])
@pytest.mark.parametrize("u_h", [(), (1.0, 2.0), (float("nan"),), (float("inf"),)])
def test_what_is_no_request_changes_nothing(make: type, u_h: tuple[float, ...]) -> None:
    request = make()
    receive(request, 0, (1.0,))
    receive(request, 10, u_h)

    assert seen(request, 10 * MS) == ((1.0,), (0.0,), 10 * MS, False)


def test_as_sent_is_the_newest_command_to_the_last_bit() -> None:
    request = pass_through()
    receive(request, 20, (0.1,), rate=(7.0,))
    receive(request, 0, (9.0,))

    assert seen(request, 30 * MS) == ((0.1,), (7.0,), 10 * MS, False)
    assert seen(request, 0) == ((0.1,), (7.0,), 0, False)


def test_ramp_is_extrapolated_between_commands_with_its_rate() -> None:
    request = estimated()
    ramp(request)

    u_h, rate, age_ns, stale = seen(request, 515 * MS)

    assert u_h == pytest.approx((0.515,), abs=1e-4)
    assert rate == pytest.approx((1.0,), abs=1e-3)
    assert (age_ns, stale) == (15 * MS, False)


def test_delay_that_varies_does_not_reach_the_rate() -> None:
    request = estimated()
    for at_ms in range(0, 501, 20):
        receive(request, at_ms, (at_ms * 1e-3,), late_ms=(at_ms * 7) % 19)

    u_h, rate, _, _ = seen(request, 510 * MS)

    assert rate == pytest.approx((1.0,), abs=1e-3)
    assert u_h == pytest.approx((0.510,), abs=1e-3)


def test_reordered_command_counts_as_a_sample_not_as_the_newest() -> None:
    in_order, overtaken = estimated(), estimated()
    for request, times in ((in_order, (0, 20, 40, 60)), (overtaken, (0, 40, 20, 60))):
        for at_ms in times:
            receive(request, at_ms, (at_ms * at_ms * 1e-3,), late_ms=60 - at_ms)

    assert seen(overtaken, 70 * MS)[:2] == seen(in_order, 70 * MS)[:2]


@pytest.mark.parametrize("how", ["release", "silence", "session", "clock stands still", "clock leaps"])
def test_estimator_restarts(how: str) -> None:
    request = estimated()
    ramp(request)
    if how == "release":
        receive(request, 510, (9.0,), enabled=False)
        receive(request, 505, (9.0,), late_ms=6, number=505)
        receive(request, 520, (0.25,))
    elif how == "silence":
        receive(request, 800, (0.25,))
    elif how == "session":
        receive(request, 520, (0.25,), epoch=2, number=0)
    elif how == "clock stands still":
        receive(request, 500, (0.25,), late_ms=20, number=501)
    else:
        receive(request, 100_000, (8.0,), late_ms=-99_490, number=502)
        receive(request, 520, (0.25,), number=503)

    # After a silence a quarter of the ramp, else in full; the rate of the estimate itself is zero.
    newest_ms, later_ms = (800, 100) if how == "silence" else (520, 10)
    u_h, _, age_ns, stale = seen(request, (newest_ms + later_ms) * MS)
    assert (u_h, age_ns, stale) == ((0.0625 if how == "silence" else 0.25,), later_ms * MS, False)


@pytest.mark.parametrize("asked_between", [False, True])
def test_samples_before_a_silence_are_discarded(*, asked_between: bool) -> None:
    request = estimated()
    ramp(request)
    if asked_between:
        seen(request, 701 * MS)
    receive(request, 490, (5.0,), late_ms=215)
    receive(request, 490, (5.0,), late_ms=215, epoch=0, number=9999)

    assert seen(request, 706 * MS) == (*ZERO, 206 * MS, True)
    receive(request, 710, (0.5,))
    assert seen(request, 850 * MS) == ((0.5,), (0.0,), 140 * MS, False)


def test_sample_that_is_stale_on_arrival_is_none() -> None:
    expected, request = estimated(), estimated()
    for each in (expected, request):
        receive(each, 0, (0.0,))
        receive(each, 20, (0.02,))
        receive(each, 150, (0.15,), late_ms=50)
    receive(request, 10, (9.0,), late_ms=215, number=15)

    assert seen(request, 230 * MS)[0] == pytest.approx(seen(expected, 230 * MS)[0], abs=1e-4)
    receive(request, 160, (9.0,), late_ms=290)
    u_h, rate, age_ns, stale = seen(request, 460 * MS)
    assert (u_h, rate, stale) == (*ZERO, True)
    assert age_ns == pytest.approx(300 * MS, abs=MS)


def test_minimum_delay_is_relaxed_at_the_drift_rate() -> None:
    clock = SenderClock()
    assert clock.update(0, 5 * MS) == 0
    assert clock.update(1000 * MS, 1007 * MS) == 2 * MS - 100_200
    assert clock.now_s(1007 * MS) == pytest.approx(1.0 + 0.002 - 0.0001002, abs=1e-12)
    assert clock.sent_s(1000 * MS) == 1.0


def test_reordered_message_does_not_set_the_clock_back() -> None:
    clock = SenderClock()
    clock.update(40 * MS, 60 * MS)
    clock.update(20 * MS, 61 * MS)

    assert not clock.advances(30 * MS)
    assert clock.advances(41 * MS)


def test_a_rate_that_the_device_tells_is_not_used() -> None:
    request = estimated()
    receive(request, 0, (1.0,), rate=(50.0,))

    assert seen(request, 10 * MS)[:2] == ((1.0,), (0.0,))
