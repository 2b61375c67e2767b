"""How a supervised run is told to have ended."""

import pytest
from passafe_services.loop.process_exit import Exit, ExitCause, RunOutcome


def ended(returncode: int, *, asked: bool = True, forced: bool = False) -> Exit:
    return Exit(name="plant", returncode=returncode, asked=asked, forced=forced)


@pytest.mark.parametrize(
    ("returncode", "how"),
    [
        (0, "exit code 0"),
        (3, "exit code 3"),
        (-9, "killed by SIGKILL"),
        (-15, "killed by SIGTERM"),
        (-40, "killed by signal 40"),
    ],
)
def test_an_end_in_words(returncode: int, how: str) -> None:
    assert ended(returncode).how == how


@pytest.mark.parametrize(
    ("cause", "end", "clean"),
    [
        (ExitCause.DURATION, ended(0), True),
        (ExitCause.SIGNAL, ended(0), True),
        (ExitCause.LEFT, ended(0, asked=False), True),
        (ExitCause.DIED, ended(0), False),
        (ExitCause.NOT_READY, ended(0), False),
        (ExitCause.NOT_STARTED, ended(0), False),
        (ExitCause.DURATION, ended(1), False),
        (ExitCause.DURATION, ended(-9, forced=True), False),
    ],
)
def test_what_is_a_clean_end(cause: ExitCause, end: Exit, clean: bool) -> None:
    assert RunOutcome(cause=cause, culprit=None, detail="", exits=(end,)).clean is clean


def test_who_died_is_told_from_who_was_stopped() -> None:
    ends = (ended(-9, asked=False), ended(0, asked=False), ended(-9, forced=True), ended(1))
    assert RunOutcome(cause=ExitCause.DIED, culprit="plant", detail="", exits=ends).died == ends[:1]


def test_a_process_that_was_started_again_is_counted_and_spoils_nothing() -> None:
    again = Exit(name="filter", returncode=-9, asked=False, forced=False, restarted=True)
    outcome = RunOutcome(cause=ExitCause.SIGNAL, culprit=None, detail="", exits=(again, again, ended(0)))
    assert outcome.clean
    assert outcome.restarts == {"filter": 2}
    assert outcome.died == (again, again)


@pytest.mark.parametrize(
    ("ready", "asked", "forced", "well"),
    [(False, True, False, True), (True, True, False, False), (False, False, False, False), (False, True, True, False)],
)
def test_only_what_was_asked_before_it_was_ready_may_die_of_it(
    ready: bool, asked: bool, forced: bool, well: bool
) -> None:
    end = Exit(name="filter", returncode=-15, asked=asked, forced=forced, ready=ready)
    assert end.well is well
