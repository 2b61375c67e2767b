"""Anderson's acceleration on affine answers, where it is exact."""

import numpy as np
import pytest

from passafe.answers.fixed_point import FixedPoint


@pytest.mark.parametrize("m", [1, 2, 3])
def test_affine_answers_with_steep_slopes_settle(m: int) -> None:
    """Answers Au + b with slopes beyond 1, from which plain iteration runs away, are solved after m + 1 answers."""
    rng = np.random.default_rng(70 + m)
    for _ in range(20):
        turn, _ = np.linalg.qr(rng.normal(size=(m, m)))
        A = turn @ np.diag(-rng.uniform(1.5, 4.0, m)) @ turn.T
        b, search = rng.normal(size=m), FixedPoint()
        u = rng.normal(size=m)
        for _ in range(m + 1):
            u = search.next(u, A @ u + b)

        assert u == pytest.approx(np.linalg.solve(np.eye(m) - A, b), abs=1e-7)
