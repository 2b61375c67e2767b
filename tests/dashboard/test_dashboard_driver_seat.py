"""The seat of the page that drives: one at a time, lost by silence, by leaving and to another operator."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from passafe_dashboard.live.driver_seat import ANSWER_NS, FRESH_NS, SILENT_NS, DriverSeat, PageCommand
from passafe_protocol.messages import OperatorLease

MS = 1_000_000
ECHO = (7, 5, 2)


def command(made_ns: int, *shares: float) -> PageCommand:
    return PageCommand(shares=shares or (0.5, -0.5), engaged=True, made_ns=made_ns)


def lease(device: str, holder: int = 7) -> OperatorLease:
    return OperatorLease(1, holder, device, 0)


def driving(page: int = 3, at_ns: int = 0, *, over: bool = False) -> DriverSeat:
    seat = DriverSeat()
    assert seat.take(page, at_ns, over=over, other="keyboard" if over else "") == ""
    return seat


def test_nothing_is_said_before_a_page_drives() -> None:
    seat = DriverSeat()
    assert seat.message(0, ECHO) is None
    assert seat.hand_to_script(1, 0) == ""
    assert not seat.release(1, 0)
    assert seat.message(0, ECHO) is None


def test_the_message_holds_command_age_and_echo() -> None:
    seat = driving(over=True)
    assert seat.steer(3, command(10 * MS), 15 * MS)

    message = seat.message(20 * MS, ECHO)

    assert message is not None
    assert (message.turn, message.driver, message.page) == (1, "page", 3)
    assert (message.shares, message.engaged, message.age_ns) == ((0.5, -0.5), True, 10 * MS)
    assert (message.take_over, message.echoed_epoch, message.echoed_ns, message.echoed_for_ns) == (True, *ECHO)


@pytest.mark.parametrize("other", ["", "keyboard"])
def test_a_second_page_has_to_take_over(other: str) -> None:
    seat = driving()
    assert seat.take(4, MS, over=False, other=other) == "page 3 drives"
    assert seat.page == 3
    assert seat.take(4, MS, over=True, other=other) == ""
    assert (seat.page, seat.turn, seat.reason) == (4, 2, "taken by page 4")
    assert not seat.steer(3, command(MS), MS)


def test_another_operator_has_to_be_taken_over() -> None:
    seat = DriverSeat()
    assert seat.take(3, 0, over=False, other="keyboard") == "another operator drives (keyboard)"
    assert seat.message(0, ECHO) is None


def test_silence_frees_the_seat() -> None:
    seat = driving()
    assert seat.steer(3, command(0), 0)
    assert not seat.expire(SILENT_NS)
    assert seat.expire(SILENT_NS + 1)
    assert (seat.page, seat.reason) == (0, "the page was silent")
    assert not seat.steer(3, command(SILENT_NS), SILENT_NS + 2)  # it has to take it again


def test_a_page_that_stuttered_keeps_the_seat() -> None:
    seat = driving()
    assert seat.steer(3, command(0), 0)
    assert seat.steer(3, command(SILENT_NS), SILENT_NS)
    assert seat.page == 3


def test_a_new_driver_has_as_long_for_its_first_command() -> None:
    seat = driving()
    assert not seat.expire(SILENT_NS)
    assert seat.expire(SILENT_NS + 1)


def test_stale_commands_do_not_keep_the_seat() -> None:
    seat = driving()
    assert seat.steer(3, command(0), 0)
    assert seat.steer(3, command(0), FRESH_NS)
    assert not seat.steer(3, command(0), FRESH_NS + 1)
    assert not seat.steer(3, command(SILENT_NS - FRESH_NS - 1), SILENT_NS)
    assert seat.expire(SILENT_NS + 1)


def test_release_and_script() -> None:
    seat = driving()
    assert seat.hand_to_script(4, MS) == "page 3 drives"
    assert seat.release(3, MS)
    assert (seat.who, seat.page, seat.since_ns) == ("nobody", 0, MS)
    assert seat.hand_to_script(4, 2 * MS) == ""
    assert seat.who == "script"


def test_the_lease_decides_between_operators() -> None:
    seat = driving()
    seat.steer(3, command(0), 0)
    assert not seat.observe(lease("lag"), MS)  # the operator has not answered yet
    assert not seat.observe(lease("page"), 2 * MS)
    assert not seat.observe(lease("", holder=0), 2 * MS)
    assert seat.observe(lease("keyboard"), 3 * MS)
    assert (seat.page, seat.reason) == (0, "another operator took over (keyboard)")


def test_an_operator_that_does_not_follow_frees_the_seat() -> None:
    seat = driving()
    assert not seat.observe(lease("keyboard"), ANSWER_NS)
    assert seat.observe(lease("keyboard"), ANSWER_NS + 1)
    assert seat.reason == "another operator drives (keyboard)"


actions = st.lists(
    st.tuples(
        st.sampled_from(["take", "over", "steer", "release", "script", "expire"]),
        st.integers(1, 3),
        st.integers(0, 300 * MS),
        st.integers(0, 300 * MS),
    ),
    max_size=30,
)


@given(actions)
def test_only_the_newest_page_in_the_seat_steers(steps: list[tuple[str, int, int, int]]) -> None:
    seat, now_ns = DriverSeat(), 0
    turns = [0]
    for action, page, gap_ns, age_ns in steps:
        now_ns += gap_ns
        before = seat.page
        match action:
            case "take" | "over":
                refused = seat.take(page, now_ns, over=action == "over", other="")
                assert (seat.page == page) == (not refused)
                assert not refused or before not in {0, page}
            case "steer":
                if seat.steer(page, command(now_ns - age_ns), now_ns):
                    assert page == before == seat.page
                    assert age_ns <= FRESH_NS
            case "release":
                assert seat.release(page, now_ns) == (before == page)
            case "script":
                seat.hand_to_script(page, now_ns)
            case _:
                seat.expire(now_ns)
        message = seat.message(now_ns, ECHO)
        assert ((message is not None and message.page) or 0) == seat.page
        assert seat.turn >= turns[-1]
        turns.append(seat.turn)
