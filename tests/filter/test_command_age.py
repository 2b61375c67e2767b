"""Age of commands: what was too long on the way does not count, and what counts again ramps in."""

from collections.abc import Sequence
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_protocol.messages import VIRTUAL_CLOCK, CommandState, Event, Header, OperatorCommand, Received
from passafe_services.filter.build import request_of
from passafe_services.filter.command_events import CommandEventEmitter
from passafe_services.filter.operator_request import OperatorRequest, PassThroughRequest
from passafe_services.filter.send_time import SendTime
from passafe_services.scenarios.load import load_scenario

MS = 1_000_000
STALE_MS, FADE_MS, RESUME_MS = 200, 100, 500
ESTIMATOR = {"kind": "white-acceleration", "agility": 50.0, "resolution": 0.05}


def make(estimator: object = None, **operator: object) -> PassThroughRequest:
    overrides = {f"operator.{key}": value for key, value in operator.items()}
    if estimator is not None:
        overrides["operator.estimator"] = estimator
    return request_of(load_scenario("notomista-cai-2020", overrides), 1, SendTime(VIRTUAL_CLOCK))


def send(
    request: PassThroughRequest,
    sent_ms: float,
    arrives_ms: float,
    u_h: float = 1.0,
    *,
    enabled: bool = True,
    epoch: int = 1,
    number: int | None = None,
) -> None:
    order = round(sent_ms) if number is None else number
    header = Header("operator", epoch, order, round(sent_ms * MS), 0, 0, 0, VIRTUAL_CLOCK)
    body = OperatorCommand((u_h,), (), enabled, "test")
    request.receive(Received(header, body, round(arrives_ms * MS)), body)


def at(request: PassThroughRequest, now_ms: float) -> OperatorRequest:
    return request.at(round(now_ms * MS))


@pytest.mark.parametrize("estimator", [None, ESTIMATOR])
def test_operator_whose_link_is_too_slow_from_the_start(estimator: object) -> None:
    request = make(estimator)
    for sent_ms in range(0, 1000, 10):
        send(request, sent_ms, sent_ms + 201)
        found = at(request, sent_ms + 205)

        assert (found.u_h, found.state, found.share) == ((0.0,), CommandState.DELAYED, 0.0)
        assert (found.age_ns, found.is_stale) == (205 * MS, True)


@pytest.mark.parametrize("delay_ms", [0, 150, 190])
def test_delay_below_the_limit_changes_nothing(delay_ms: int) -> None:
    request = make()
    for sent_ms in range(0, 1000, 10):
        send(request, sent_ms, sent_ms + delay_ms, sent_ms)
        found = at(request, sent_ms + delay_ms)

        assert (found.u_h, found.u_h_rate, found.share) == ((sent_ms,), (0.0,), 1.0)
        assert (found.state, found.age_ns) == (CommandState.COUNTS, delay_ms * MS)


def test_age_goes_on_after_the_arrival() -> None:
    request = make()
    send(request, 0, 150)

    assert at(request, 200).state is CommandState.COUNTS
    assert at(request, 201).state is CommandState.SILENT
    assert at(request, 250).u_h == pytest.approx((0.5,))


def test_slowly_growing_delay_fades_once() -> None:
    """Commands that come ever later must not begin the fade anew."""
    request = make()
    u_h = []
    for sent_ms in range(0, 2000, 10):
        arrives_ms = sent_ms * 1.25
        send(request, sent_ms, arrives_ms, 2.0)
        u_h.append((arrives_ms, at(request, arrives_ms).u_h[0]))

    # From an age of 190 ms on every command is stale before the next one comes, from 200 ms on when it comes.
    assert {u for t, u in u_h if t <= 950} == {2.0}
    assert all(1.5 < u <= 2.0 for t, u in u_h if t <= 1000)
    assert all(u <= max(0.0, 2.0 - 2.0 * (t - 1010) / FADE_MS) + 1e-9 for t, u in u_h if t > 1010)


def test_resumption_ramps_from_where_the_fade_is() -> None:
    """At 230 ms 70 % of the command are left, so the ramp takes 150 of 500 ms."""
    request = make()
    send(request, 0, 0, 2.0)
    at(request, 200)
    assert at(request, 225).u_h == pytest.approx((1.5,))

    send(request, 220, 230, -3.0)

    begins, later = at(request, 230), at(request, 290)
    assert begins.u_h == pytest.approx((1.4,))
    assert (begins.state, begins.share) == (CommandState.RESUMES, 0.0)
    assert later.u_h == pytest.approx((0.4 * -3.0 + 0.6 * 0.2,))
    assert later.u_h_rate == pytest.approx((0.6 * -20.0 + (-3.0 - 0.2) / 0.15,))
    assert later.share == pytest.approx(0.4)
    assert at(request, 380) == OperatorRequest((-3.0,), (0.0,), 160 * MS, CommandState.COUNTS, 1.0)


def test_short_stretch_does_not_cut_a_ramp_short() -> None:
    request = make()
    send(request, 0, 0)
    at(request, 0)
    send(request, 900, 1000)
    assert at(request, 1100).share == pytest.approx(0.2)
    assert at(request, 1105).u_h == pytest.approx((0.95 * 0.2,))
    send(request, 1105, 1110)

    send(request, 1300, 1300)

    # 18 % of the command were left, so the ramp takes 410 ms.
    assert at(request, 1315).share == pytest.approx(0.5)


def test_shrinking_delay_replays_nothing_old() -> None:
    """Three seconds of commands come at once, oldest first, before the first that counts."""
    request = make()
    send(request, 0, 0, 5.0)
    at(request, 0)
    at(request, 1000)
    for sent_ms in range(10, 2800, 10):
        send(request, sent_ms, 3000, 5.0)
        assert at(request, 3000).u_h == (0.0,)
    send(request, 2990, 3000, -1.0)

    assert at(request, 3000).u_h == (0.0,)
    assert at(request, 3100).u_h == pytest.approx((-0.2,))


def test_first_command_after_only_late_ones_ramps_in() -> None:
    request = make()
    send(request, 0, 300)
    send(request, 290, 310)

    assert at(request, 310).share == 0.0
    assert at(request, 410).u_h == pytest.approx((0.2,))


def test_first_command_of_all_counts_at_once() -> None:
    request = make()
    send(request, 0, 30)

    assert (at(request, 30).u_h, at(request, 30).share) == ((1.0,), 1.0)


def test_new_operator_after_a_silence_ramps_in() -> None:
    request = make()
    send(request, 0, 0)
    at(request, 0)
    send(request, 5000, 5000, epoch=2, number=0)

    assert at(request, 5000).u_h == (0.0,)
    send(request, 5190, 5190, epoch=2, number=1)
    assert at(request, 5250).u_h == pytest.approx((0.5,))


@pytest.mark.parametrize("was_counting", [True, False])
def test_release_counts_however_late_it_comes(*, was_counting: bool) -> None:
    request = make()
    if was_counting:
        send(request, 0, 0, 4.0)
        at(request, 0)
    send(request, 10, 250, 4.0, enabled=False)

    assert at(request, 250).u_h == pytest.approx((2.0,) if was_counting else (0.0,))
    assert at(request, 250).is_stale
    send(request, 255, 260, 4.0, enabled=False)
    assert at(request, 260).state is CommandState.RELEASED
    assert at(request, 300).u_h == (0.0,)
    send(request, 305, 310, 4.0)
    # The ramp began at 260 ms, with 40 % left or with nothing.
    assert at(request, 310).share == pytest.approx(50 / 300 if was_counting else 50 / 500)


def test_stale_stretch_between_two_ticks_ramps_too() -> None:
    """A filter that was suspended finds old commands and a fresh one at once."""
    request = make()
    send(request, 0, 0)
    at(request, 0)
    for sent_ms in range(10, 3000, 10):
        send(request, sent_ms, 3000)

    assert at(request, 3000).u_h == (0.0,)
    assert at(request, 3000).state is CommandState.RESUMES


def texts(*requests: tuple[float, CommandState]) -> Sequence[tuple[float, Event]]:
    emitter = CommandEventEmitter(200 * MS, 500 * MS)
    found = []
    for now_ms, state in requests:
        event = emitter.event(round(now_ms * MS), OperatorRequest((0.0,), (0.0,), 3000 * MS, state, 0.0))
        if event is not None:
            found.append((now_ms, event))
    return found


def test_events_say_that_commands_are_late_and_count_again() -> None:
    late, ramp, counts = CommandState.DELAYED, CommandState.RESUMES, CommandState.COUNTS
    found = texts((0, counts), (10, late), (20, late), (5000, ramp), (5010, ramp), (5500, counts))

    assert [now_ms for now_ms, _ in found] == [10, 5000]
    assert found[0][1] == Event(
        "warning", "commands are 3000 ms old when they arrive, allowed 200 ms: they do not count"
    )
    assert found[1][1] == Event("info", "commands count again: they ramp in within 0.5 s")


def test_link_at_the_limit_is_reported_once_a_second() -> None:
    states = [CommandState.DELAYED, CommandState.RESUMES]
    found = texts(*((10.0 * k, states[k % 2]) for k in range(301)))

    assert [now_ms for now_ms, _ in found] == [0, 1010, 2020]


def test_another_command_after_a_short_silence_does_not_jump() -> None:
    request = make()
    for sent_ms in range(0, 50, 10):
        send(request, sent_ms, sent_ms, 0.0)
    assert at(request, 242).state is CommandState.SILENT
    send(request, 50, 243, 8.0)

    found = [at(request, now_ms).u_h[0] for now_ms in range(242, 252, 2)]

    assert max(after - before for before, after in pairwise(found)) == pytest.approx(8.0 * 2 / FADE_MS)


Link = st.lists(st.tuples(st.floats(0.0, 500.0), st.booleans(), st.booleans()), min_size=1, max_size=80)
"""Of every command: delay in ms, whether it is lost, whether the dead-man is held."""


@given(link=Link, u_h=st.lists(st.floats(-10, 10), min_size=80, max_size=80))
def test_no_link_brings_an_old_command_or_a_jump(link: list[tuple[float, bool, bool]], u_h: list[float]) -> None:
    """Every 10 ms a command, every 2 ms a tick; the first command always comes."""
    request = make()
    sent = [(10.0 * k, u_h[k], held) for k, (_, _, held) in enumerate(link)]
    arrivals = sorted((10.0 * k + delay_ms, k) for k, (delay_ms, lost, _) in enumerate(link) if not lost or k == 0)
    before: OperatorRequest | None = None
    for now_ms in range(0, 10 * len(link) + 1000, 2):
        while arrivals and arrivals[0][0] <= now_ms:
            arrives_ms, k = arrivals.pop(0)
            send(request, sent[k][0], arrives_ms, sent[k][1], enabled=sent[k][2])
        found = at(request, now_ms)

        young = [u for sent_ms, u, held in sent if held and 0 <= now_ms - sent_ms <= STALE_MS]
        assert abs(found.u_h[0]) <= 10.0
        if found.state is CommandState.COUNTS:
            assert found.u_h[0] in young
        elif found.state is CommandState.RESUMES:
            assert young
        if before is not None and before.is_stale and before.state is not CommandState.NONE:
            # 2 ms of the fade and of the ramp, no more; only the very first command counts in full at once
            assert abs(found.u_h[0] - before.u_h[0]) <= 20.0 * (2 / FADE_MS + 2 / RESUME_MS) + 1e-9
        before = found
    assert before is not None
    assert before.u_h == (0.0,)
