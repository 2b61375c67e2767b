"""Sets of states: their growth against a closed form and against members, and residuals."""

from collections.abc import Callable
from math import exp, inf

import casadi as ca
import numpy as np
import pytest
from core_designs import drag_design, paper_design
from uncertain_plants import AnyMembers

from passafe.design import FilterDesign
from passafe.errors import DesignError, ShapeError
from passafe.sampled_plant import SampledPlant
from passafe.state_set import ErrorGrowth, StateSet
from passafe.system import System
from passafe.uncertainty import Uncertainty


def point(**sets: object) -> FilterDesign:
    return paper_design(dt_s=0.01, k_i=20.0, uncertainty=Uncertainty(**sets))  # type: ignore[arg-type]  # sets by name


def test_without_disturbance_an_error_moves_as_the_plant_does() -> None:
    growth = ErrorGrowth(point(state_error=(0.1, 0.0, 0.2, 0.0)))

    fades = exp(-0.01)
    expected = (0.1 + (1 - fades) * 0.2, 0.0, 0.2 * fades, 0.0)
    assert growth.advance((1.0, 2.0, 3.0, 4.0), (5.0, 6.0), growth.at_measurement) == pytest.approx(expected, abs=1e-12)


def test_a_disturbance_adds_up() -> None:
    growth = ErrorGrowth(point(disturbance=(0.0, 0.0, 0.5, 0.0)))

    grown = growth.advance((1.0, 2.0, 3.0, 4.0), (5.0, 6.0), (0.0,) * 4)
    fades = exp(-0.01)
    assert grown[2] == pytest.approx(0.5 * (1 - fades), rel=1e-3)
    assert grown[0] == pytest.approx(0.5 * (0.01 - (1 - fades)), rel=0.05)
    assert grown[1] == grown[3] == 0.0


def test_small_inputs_make_small_errors() -> None:
    """With a mass up to a quarter less, the error of a push is a quarter of it: what counts is what was sent."""
    growth = ErrorGrowth(point(parameters={"mass": (0.8, 1.0)}))

    small, large = (growth.advance((0.0,) * 4, (u, 0.0), (0.0,) * 4) for u in (1.0, 10.0))
    assert small[2] == pytest.approx(0.25 * (1 - exp(-0.01)), rel=1e-2)
    assert large[2] == pytest.approx(10 * small[2])


def uncertain_drag() -> FilterDesign:
    sets = Uncertainty(
        parameters={"mass": (0.9, 1.2), "drag": (0.5, 0.9)},
        disturbance=(0, 0, 0.3, 0.1),
        state_error=(1e-3, 1e-3, 1e-2, 1e-2),
        input_error=(0.2, 0.1),
    )
    return drag_design(dt_s=0.01, uncertainty=sets)


def together() -> FilterDesign:
    return point(
        parameters={"mass": (0.8, 1.3), "sigma": (0.7, 1.2)},
        disturbance=(0.01, 0.02, 0.3, 0.4),
        state_error=(2e-3, 1e-3, 2e-2, 1e-2),
        input_error=(0.2, 0.3),
    )


@pytest.mark.parametrize("build", [together, uncertain_drag])
def test_no_member_leaves_the_set(build: Callable[[], FilterDesign]) -> None:
    design = build()
    rng = np.random.default_rng(7)
    growth, plant = ErrorGrowth(design), SampledPlant(design.system, design.passivity.V, design.dt_s)
    members = AnyMembers(design, 40, rng)
    center, radius = (0.5, -0.2, 1.0, 2.0), growth.at_measurement
    x, widest = members.starts(center, radius), 0.0
    for _ in range(25):
        u = tuple(rng.uniform(-8, 8, 2).tolist())
        radius = growth.advance(center, u, radius)
        center, x = plant.advance(center, u).x, members.follow(x, u, design.dt_s)[-1]
        share = np.abs(x - np.array(center)[:, None]) / np.array(radius)[:, None]
        assert share.max() <= 1 + 1e-9
        widest = max(widest, share.max())
    assert widest > 0.3


@pytest.mark.parametrize("build", [together, uncertain_drag])
def test_many_periods_at_once_are_as_many_one_by_one(build: Callable[[], FilterDesign]) -> None:
    design = build()
    growth, plant = ErrorGrowth(design), SampledPlant(design.system, design.passivity.V, design.dt_s)
    inputs = np.random.default_rng(1).uniform(-5, 5, (19, 2)).tolist()
    center, radius = (0.5, -0.2, 1.0, 2.0), growth.at_measurement
    start = StateSet(center=center, radius=radius)
    assert growth.roll(start, []) == start
    for k, u in enumerate(inputs):
        radius = growth.advance(center, u, radius)
        center = plant.advance(center, tuple(u)).x
        at_once = growth.roll(start, inputs[: k + 1])
        assert at_once.center == pytest.approx(center, abs=1e-12)
        assert at_once.radius == pytest.approx(radius, abs=1e-12)


def test_where_no_bound_is_known_the_error_is_infinite() -> None:
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    f = ca.vertcat(x[2:], u + 100 * x[2:] ** 3)
    system = System(x=x, u=u, f=f, y=x[2:])
    design = drag_design(
        system=system,
        u_fb=-x[:2],
        fail_safe=-x[2:],
        barriers=(),
        passivity=type(drag_design().passivity)(V=ca.sumsqr(x)),
        uncertainty=Uncertainty(disturbance=(0, 0, 1, 1)),
    )
    assert inf in ErrorGrowth(design).advance((0.0, 0.0, 50.0, 50.0), (0.0, 0.0), (0.0,) * 4)


def test_a_residual_is_one_on_the_boundary() -> None:
    growth = ErrorGrowth(point(state_error=(0.1, 0.1, 0.2, 0.2)))
    predicted = StateSet(center=(1.0, 0.0, 0.0, 0.0), radius=(0.3, 0.4, 0.0, 0.8))

    factors = growth.residual(predicted, (1.4, 0.0, 0.4, -0.5))
    assert factors == pytest.approx((1.0, 0.0, 2.0, 0.5), abs=1e-6)


def test_an_exact_model_leaves_no_residual() -> None:
    growth = ErrorGrowth(point())
    still = StateSet(center=(1.0, 0.0, 0.0, 0.0), radius=(0.0,) * 4)

    assert growth.residual(still, (1.0, 0.0, 0.0, 0.0)) == (0.0,) * 4
    assert max(growth.residual(still, (1.0 + 1e-6, 0.0, 0.0, 0.0))) > 1


def test_what_does_not_fit_is_refused() -> None:
    growth, still = ErrorGrowth(point()), StateSet(center=(0.0,) * 4, radius=(0.0,) * 4)
    with pytest.raises(DesignError, match="a design with an Uncertainty"):
        ErrorGrowth(paper_design())
    with pytest.raises(ShapeError, match="lengths 4, 2, 4"):
        growth.advance((0.0,) * 3, (0.0, 0.0), (0.0,) * 4)
    with pytest.raises(ShapeError, match="2 numbers each"):
        growth.roll(still, [(1.0,)])
    with pytest.raises(ShapeError, match="measured"):
        growth.residual(still, (1.0,))
