"""Times of a fault, from made-up timelines."""

import pytest
from timeline import GRID_NS, Timeline, without_stumbles

MS = 1_000_000


def timeline(*gaps_ms: tuple[int, int], silent_ms: tuple[int, int] = (0, 0)) -> Timeline:
    """Return one of 3 s that is not driven within the gaps, and says nothing while silent."""
    times = [at for at in range(0, 3_000, 4) if not silent_ms[0] < at <= silent_ms[1]]
    states = [(at * MS, not any(begin <= at < end for begin, end in gaps_ms)) for at in times]
    return Timeline(states, [(at * MS, True) for at in times], [(1_200 * MS, "plant", "warning", "inputs stopped")])


def test_a_fault_without_effect_is_no_loss() -> None:
    effect = timeline().effect(1_000 * MS, 1_500 * MS, 2_500 * MS)

    assert (effect.to_safe_s, effect.to_recover_s) == (None, 0.0)
    assert effect.story == ("plant: inputs stopped",)


def test_times_count_from_begin_and_end_of_the_fault() -> None:
    effect = timeline((1_100, 1_700)).effect(1_000 * MS, 1_500 * MS, 2_500 * MS)

    assert effect.to_safe_s == pytest.approx(0.1, abs=2 * GRID_NS * 1e-9)
    assert effect.to_recover_s == pytest.approx(0.2, abs=2 * GRID_NS * 1e-9)
    assert effect.undriven_s == pytest.approx(0.6, abs=2 * GRID_NS * 1e-9)


def test_robot_that_is_lost_again_has_not_recovered() -> None:
    effect = timeline((1_100, 1_350), (1_500, 1_900)).effect(1_000 * MS, 1_200 * MS, 2_500 * MS)

    assert effect.to_recover_s == pytest.approx(0.7, abs=2 * GRID_NS * 1e-9)
    assert timeline((1_100, 2_400)).effect(1_000 * MS, 1_200 * MS, 2_500 * MS).to_recover_s is None


def test_stumble_is_measured_and_no_loss() -> None:
    effect = timeline((1_300, 1_450), (2_000, 2_100)).effect(1_000 * MS, 1_200 * MS, 2_500 * MS)

    assert (effect.to_safe_s, effect.to_recover_s) == (None, 0.0)
    assert effect.undriven_s == pytest.approx(0.25, abs=4 * GRID_NS * 1e-9)
    assert without_stumbles([False, True, False, True, False], 1) == [False, True, True, True, False]


def test_silence_is_no_driving() -> None:
    effect = timeline(silent_ms=(1_000, 2_000)).effect(1_000 * MS, 2_000 * MS, 2_900 * MS)

    assert effect.to_safe_s == pytest.approx(0.06, abs=2 * GRID_NS * 1e-9)
    assert effect.to_recover_s == pytest.approx(0.0, abs=2 * GRID_NS * 1e-9)
