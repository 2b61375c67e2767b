"""Exits of processes and outcomes of supervised runs."""

import pytest
from passafe_services.loop.process_exit import Exit, ExitCause, RunOutcome


def ended(returncode: int, *, requested: bool = True, killed: bool = False) -> Exit:
    return Exit(name="plant", returncode=returncode, requested=requested, killed=killed)


ON_REQUEST = Exit(name="plant", returncode=-9, requested=True, killed=True, ended_on_request=True)


@pytest.mark.parametrize(
    ("returncode", "description"),
    [
        (0, "exit code 0"),
        (3, "exit code 3"),
        (-9, "killed by SIGKILL"),
        (-15, "killed by SIGTERM"),
        (-40, "killed by signal 40"),
    ],
)
def test_an_end_in_words(returncode: int, description: str) -> None:
    assert ended(returncode).description == description


@pytest.mark.parametrize(
    ("cause", "end", "clean"),
    [
        (ExitCause.DURATION, ended(0), True),
        (ExitCause.SIGNAL, ended(0), True),
        (ExitCause.LEFT, ended(0, requested=False), True),
        (ExitCause.REQUESTED, ended(0), True),
        (ExitCause.REQUESTED, ended(1), False),
        (ExitCause.SIGNAL, ON_REQUEST, True),
        (ExitCause.DIED, ended(0), False),
        (ExitCause.NOT_READY, ended(0), False),
        (ExitCause.NOT_STARTED, ended(0), False),
        (ExitCause.DURATION, ended(1), False),
        (ExitCause.DURATION, ended(-9, killed=True), False),
    ],
)
def test_what_is_a_clean_end(cause: ExitCause, end: Exit, clean: bool) -> None:
    assert RunOutcome(cause=cause, culprit=None, detail="", exits=(end,)).clean is clean


def test_dead_processes_are_distinguished_from_stopped_ones() -> None:
    ends = (ended(-9, requested=False), ended(0, requested=False), ended(-9, killed=True), ended(1))
    assert RunOutcome(cause=ExitCause.DIED, culprit="plant", detail="", exits=ends).died == ends[:1]


def test_restarted_process_is_counted_and_the_run_stays_clean() -> None:
    again = Exit(name="filter", returncode=-9, requested=False, killed=False, restarted=True)
    outcome = RunOutcome(cause=ExitCause.SIGNAL, culprit=None, detail="", exits=(again, again, ended(0)))
    assert outcome.clean
    assert outcome.restarts == {"filter": 2}
    assert outcome.died == (again, again)


@pytest.mark.parametrize(
    ("ready", "requested", "killed", "clean"),
    [(False, True, False, True), (True, True, False, False), (False, False, False, False), (False, True, True, False)],
)
def test_sigterm_death_is_clean_only_on_request_before_ready(
    ready: bool, requested: bool, killed: bool, clean: bool
) -> None:
    end = Exit(name="filter", returncode=-15, requested=requested, killed=killed, ready=ready)
    assert end.clean is clean
