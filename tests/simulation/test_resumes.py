"""The robot resumes after stops, deaths and outages without a jump, and without a command of before.

``make resumes`` runs the whole campaign: a thousand resumes.
"""

import pytest
from resume_run import (
    inputs_in_spite_of_a_stop,
    largest_rate_excess,
    oldest_after_clear_ns,
    requests_before_they_may,
    resumes,
    run_of,
)

ROUNDING = 1e-9
SLICE = range(7)
CAMPAIGN = range(1_000, 1_190)
LEAST_RESUMES = 1_000


def check(seed: int) -> int:
    """Check a run; return how often the robot resumed in it."""
    scenario, record = run_of(seed)
    assert largest_rate_excess(scenario, record) <= ROUNDING, seed
    assert inputs_in_spite_of_a_stop(record) == [], seed
    assert requests_before_they_may(record) == [], seed
    oldest_ns = oldest_after_clear_ns(scenario, record)
    assert oldest_ns is None or oldest_ns > 0, seed
    assert record.states[-1][1].stop == 0, seed
    return resumes(record)


@pytest.mark.parametrize("seed", SLICE)
def test_resumes_neither_jump_nor_apply_old_commands(seed: int) -> None:
    assert check(seed) > 2


@pytest.mark.campaign
def test_a_thousand_resumes() -> None:
    assert sum(map(check, CAMPAIGN)) >= LEAST_RESUMES
