"""Remnant: its density at low frequencies, its bandwidth, its seed."""

from math import exp, pi

import numpy as np
import pytest
from passafe_services.operator.human.remnant import Remnant

RATIO = 0.01


def series(steps: int, *, bandwidth: float = 20.0, glance_s: float = 0.02, count: int = 2, seed: int = 3) -> np.ndarray:
    remnant = Remnant(ratio=RATIO, bandwidth_rad_per_s=bandwidth, glance_s=glance_s, count=count, seed=seed)
    return np.array([list(remnant.step()) for _ in range(steps)])


@pytest.mark.parametrize(("bandwidth", "glance_s"), [(20.0, 0.02), (20.0, 0.2), (1000.0, 0.01)])
def test_its_density_at_low_frequencies_is_the_stated_share(bandwidth: float, glance_s: float) -> None:
    """The mean over a time D much longer than its memory has variance πρ/D."""
    windows, long_s = 400, 10.0
    each = round(long_s / glance_s)
    means = series(windows * each, bandwidth=bandwidth, glance_s=glance_s).reshape(windows, each, 2).mean(axis=1)

    # 800 independent means: their variance is known to √(2/800) = 5 %, and three times that is allowed.
    assert means.var() == pytest.approx(pi * RATIO / long_s, rel=0.15)


def test_its_memory_is_one_over_its_bandwidth() -> None:
    n = series(200_000)[1000:]
    remnant = Remnant(ratio=RATIO, bandwidth_rad_per_s=20.0, glance_s=0.02, count=2, seed=0)

    assert n.std() == pytest.approx(remnant.deviation, rel=0.02)
    assert (n[1:] * n[:-1]).mean() / n.var() == pytest.approx(exp(-20.0 * 0.02), rel=0.02)
    assert (n[:, 0] * n[:, 1]).mean() / n.var() == pytest.approx(0.0, abs=0.02)


def test_a_seed_decides_it_and_no_ratio_is_no_noise() -> None:
    assert np.array_equal(series(100, seed=5), series(100, seed=5))
    assert not np.array_equal(series(100, seed=5), series(100, seed=6))
    quiet = Remnant(ratio=0.0, bandwidth_rad_per_s=20.0, glance_s=0.02, count=2, seed=0)
    assert quiet.step() == [0.0, 0.0]
