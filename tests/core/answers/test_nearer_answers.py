"""Answers nearer to what is asked for, where margins of wide trust regions would lead away from it."""

import casadi as ca
import numpy as np
import pytest
from core_designs import paper_design

import passafe.answers.attempts
from passafe.answers.attempts import Attempts
from passafe.barrier_chain import Barrier
from passafe.decision import Attempt, Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant
from passafe.system import System


def heated(dt_s: float) -> SafetyPassivityFilter:
    """Return a filter that keeps the first of three stages, with rates of 0.3, 4 and 30 per second, below 5."""
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    f = ca.vertcat(-0.3 * x[0] + 2 * x[1], -4 * (x[1] - x[2]), -30 * (x[2] - u))
    return SafetyPassivityFilter(
        FilterDesign(
            system=System(x=x, u=u, f=f, y=x[1]),
            barriers=(Barrier(name="hot", h=5 - x[0], class_k=(1.0,) * 4),),
            passivity=Passivity(V=x[1] ** 2 / 2),
            k_i=4.0,
            dt_s=dt_s,
            input_bound=10.0,
            mode=Mode.SAFE,
        )
    )


@pytest.mark.parametrize("dt_s", [0.05, 0.2])
def test_a_request_is_followed_as_far_as_rows_allow(dt_s: float) -> None:
    """Six time constants long: margins for wide trust regions would lead away at full power, for ever."""
    made = heated(dt_s)
    plant = SampledPlant(made.design.system, made.design.passivity.V, dt_s)
    x, u = (0.0,) * 3, (0.0,)
    for _ in range(round(20 / dt_s)):
        decision = made.decide(x, u, (9.0,), (0.0,))
        u = decision.u
        x = plant.advance(x, u).x
        assert decision.status in {Status.PASSED, Status.MODIFIED}
        assert u[0] >= -1e-9
        assert x[0] <= 5
    assert x[0] > 0.5


def test_search_ends_where_narrower_regions_regain_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Braking before the disk: nearly all of the margin is for what the state does, whatever is sent."""
    regions: list[float] = []
    confined = Attempts.confined

    def counted(attempts: Attempts, u_lin: Array, trust: Array) -> Attempt:
        regions.append(float(trust.max()))
        return confined(attempts, u_lin, trust)

    monkeypatch.setattr(Attempts, "confined", counted)
    braking = ((-0.128, -1.991, 0.745, 1.461), (3.587, 3.747), (-3.039, 4.814), (0.0, 0.0))
    decision = SafetyPassivityFilter(paper_design(dt_s=0.01, k_i=50.0)).decide(*braking)

    assert decision.status is Status.MODIFIED
    assert len(regions) == 3  # two in the first narrower region, and the better one's once more
    assert len(set(regions)) == 1


def test_the_nearest_of_all_regions_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """At rest: the margin for all of the way to û leaves −2 and less, that for a small part of it a little push."""
    made = heated(0.2)
    request = ((0.0,) * 3, (0.0,), (9.0,), (0.0,))
    decision = made.decide(*request)
    assert decision.u[0] > 0
    assert np.abs(decision.u[0] - decision.part("u_lin")[0]) <= decision.part("trust")[0]
    monkeypatch.setattr(passafe.answers.attempts, "NARROWINGS", 0)

    assert made.decide(*request).u[0] < -2
