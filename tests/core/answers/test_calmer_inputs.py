"""Inputs that move the state less are tried where margins grow steeply with the input."""

import casadi as ca
import numpy as np
import pytest

import passafe.answers.calmer_inputs
from passafe.barrier_chain import Barrier
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.models.lagged_point import lagged_point
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant

STEEP = ([0.3229, 0.1696, 0.4249, -0.8809, -50.5713, -51.9668], (-50.5114, -51.9159), (40.0, 25.0), (0.0, 0.0))


def arena() -> SafetyPassivityFilter:
    """Return a filter for a lagged point in a disk: lag 6 ms, inputs held for 30 ms, five lags."""
    robot = lagged_point(sigma=0.5, lag_s=0.006)
    keep_in = Barrier(name="arena", h=2 - ca.sumsqr(robot.position), class_k=(20.0, 20.0, 20.0, 20.0))
    return SafetyPassivityFilter(
        FilterDesign(
            system=robot.system,
            u_fb=ca.SX.zeros(2),
            fail_safe=ca.SX.zeros(2),
            barriers=(keep_in,),
            passivity=Passivity(V=ca.sumsqr(robot.velocity) / 2),
            k_i=10.0,
            dt_s=0.03,
            input_bound=60.0,
            mode=Mode.SAFE,
        )
    )


def test_a_calmer_input_keeps_rows_that_the_wanted_one_cannot(monkeypatch: pytest.MonkeyPatch) -> None:
    made = arena()
    decision = made.decide(*STEEP)
    u_lin, trust = decision.part("u_lin"), decision.part("trust")

    assert decision.status is Status.MODIFIED
    assert decision.part("shortfall")[0] <= 0
    assert (np.abs(np.array(decision.u) - u_lin) <= trust + 1e-9).all()
    monkeypatch.setattr(passafe.answers.calmer_inputs, "SHARES", ())
    assert made.decide(*STEEP).status is Status.AT_SAMPLES


def test_held_five_lags_long_the_arena_is_never_left() -> None:
    made = arena()
    plant = SampledPlant(made.design.system, made.design.passivity.V, 0.03)
    x, u = (0.0,) * 6, (0.0, 0.0)
    for k in range(120):
        push = (40.0, 25.0) if (k // 15) % 2 == 0 else (-40.0, 10.0)
        u = made.decide(x, u, push, (0.0, 0.0)).u
        x = plant.advance(x, u).x
        assert x[0] ** 2 + x[1] ** 2 <= 2
