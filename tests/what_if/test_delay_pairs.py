"""A what-if under 150 ms more shows what a run recorded under them shows, within these tolerances.

The operator of the what-if is that of the log, in open loop: its script starts with the robot that it steered then, not
with the one that starts 150 ms later now. Hence robots are apart by some of that time.
"""

from pathlib import Path

import pytest
from delay_pairs import delay_pair

H_TOLERANCE = 0.01
AGE_TOLERANCE_MS = 5.0
OVERRIDDEN_TOLERANCE = 0.06
POSITION_TOLERANCE = 0.4


def agrees(seed: int, folder: Path, *, duration_s: float = 4.0) -> None:
    pair = delay_pair(seed, folder, duration_s=duration_s)
    assert pair.asked == pair.recorded, pair
    assert abs(pair.h_apart) <= H_TOLERANCE, pair
    assert abs(pair.age_ms_apart) <= AGE_TOLERANCE_MS, pair
    assert abs(pair.overridden_apart) <= OVERRIDDEN_TOLERANCE, pair
    assert pair.position_rms <= POSITION_TOLERANCE, pair


def test_pair_under_more_delay_agrees(tmp_path: Path) -> None:
    agrees(0, tmp_path, duration_s=0.8)


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(20))
def test_twenty_pairs_under_more_delay_agree(seed: int, tmp_path: Path) -> None:
    agrees(seed, tmp_path)
