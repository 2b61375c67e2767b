"""INFEASIBLE is said with a proof: weights with which the hard rows ask for more than any input gives (Farkas)."""

from itertools import product

import numpy as np
import pytest
from core_designs import drag_design

from passafe.filter import SafetyPassivityFilter

BOUND = np.array([5.0, 8.0])
NORM = 6.0


@pytest.mark.parametrize("norm", [None, NORM])
def test_conflict_is_demand_of_weighted_rows_beyond_the_limits(norm: float | None) -> None:
    """Σλᵢdᵢ − max (Σλᵢgᵢ)ᵀw over the box, by its corners, and over the disc, where ‖pull‖·B is reached."""
    design = drag_design(input_bound=tuple(BOUND.tolist()), input_norm_bound=norm)
    derivation = SafetyPassivityFilter(design).derivation
    rng = np.random.default_rng(90)
    proven = 0
    for _ in range(200):
        G, d, weights = rng.normal(size=(3, 3)), rng.normal(size=3) * 8, rng.uniform(0.0, 2.0, 2)
        low, high = -BOUND * rng.uniform(0.2, 1.0, 2), BOUND * rng.uniform(0.2, 1.0, 2)
        u_ref = rng.uniform(low, high)
        pull = weights @ G[:2, :2]
        gives = max(float(pull @ (np.array(corner) - u_ref)) for corner in product(*zip(low, high, strict=True)))
        if norm is not None:
            gives = min(gives, norm * float(np.linalg.norm(pull)) - float(pull @ u_ref))
        posed = {"G": G, "d": d, "u_ref": u_ref, "low": low, "high": high}
        given = posed | {"relax": weights}
        prove = derivation.functions.prove_conflict
        value = float(prove(*(given.get(name, np.zeros(derivation.layout.shapes[name])) for name in prove.name_in())))

        assert value == pytest.approx(float(weights @ d[:2]) - gives, abs=1e-12)
        if value > 0:
            proven += 1
            tried = rng.uniform(low, high, (300, 2))
            tried = tried[np.linalg.norm(tried, axis=1) <= (norm or np.inf)]
            assert ((tried - u_ref) @ G[:2, :2].T < d[:2]).any(axis=1).all()
    assert proven > 20
