"""A short slice of what ``make worker-kills`` runs."""

import pytest
from worker_kills import BOUND_S, kill_of_command, kill_of_pool


@pytest.mark.timeout(2 * BOUND_S)
@pytest.mark.parametrize("seed", range(1, 10))
def test_a_worker_killed_at_a_random_moment_is_reported(seed: int) -> None:
    kill = kill_of_pool(seed)

    assert kill.reported_s <= kill.ended_s < BOUND_S


@pytest.mark.live
@pytest.mark.timeout(2 * BOUND_S)
def test_a_killed_worker_ends_the_command_with_one_line(tmp_path_factory: pytest.TempPathFactory) -> None:
    assert kill_of_command(0, tmp_path_factory.mktemp("kills")).ended_s < BOUND_S
