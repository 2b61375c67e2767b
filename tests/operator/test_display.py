"""The one line that an operator sees."""

import pytest
from passafe_protocol.messages import FilterStatus
from passafe_services.operator.keyboard.display import OperatorView, line

FULL = OperatorView(
    u_h=(-14.5, 0.0),
    enabled=True,
    holder="",
    stop_source="",
    position=(-1.25, 0.031),
    status=FilterStatus.MODIFIED,
    nearest=("disk", 0.0021),
)


def test_line_shows_command_and_filter_status() -> None:
    text = line(FULL, 120)
    for part in (
        "HELD",
        "u_h ( -14.50,   +0.00)",
        "robot (  -1.25,   +0.03)",
        "filter MODIFIED",
        "h(disk) +0.002",
    ):
        assert part in text


def test_line_shows_unknown_values() -> None:
    text = line(FULL._replace(enabled=False, position=None, status=None, nearest=None), 120)
    assert "released" in text
    assert "robot ?" in text
    assert "filter ?" in text
    assert "h(" not in text


def test_a_waiting_operator_sees_no_command_as_if_it_were_sent() -> None:
    text = line(FULL._replace(holder="session 7 (lag\x1b)"), 120)
    assert text == "WAITING: t takes over, q ends; operator session 7 (lag?) holds the lease"


def test_a_stop_takes_the_whole_line() -> None:
    text = line(FULL._replace(stop_source="console", holder="session 7 (lag)"), 120)
    assert text == "EMERGENCY STOP by console: clear it on the page or with `passafe clear`"


@pytest.mark.parametrize("columns", [-1, 0, 1, 40, 79])
def test_a_line_fits(columns: int) -> None:
    assert len(line(FULL, columns)) == max(columns, 0)


def test_a_name_off_the_wire_cannot_steer_the_terminal() -> None:
    text = line(FULL._replace(nearest=("\x1b]0;owned\x07é", 1.0)), 200)
    assert "h(?]0;owned??)" in text
