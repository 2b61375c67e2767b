"""Families of plants: coordinates, ends, reserves, and decisions with them."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import gains, paper_design, paper_passivity

from passafe.barrier_chain import Barrier
from passafe.batch.batch_filter import BatchFilter
from passafe.decision import Decision, Status
from passafe.design import FilterDesign, Mode
from passafe.enclosures.reachable_tube import tube_of
from passafe.errors import DesignError, ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.margins.intersample_margin import general_row
from passafe.margins.member_bound import member_bound
from passafe.margins.plant_family import PlantFamily
from passafe.parameter import Parameter
from passafe.system import System
from passafe.uncertainty import Uncertainty

MASS = Uncertainty(parameters={"mass": (0.8, 1.25)})
ZERO = (0.0, 0.0)


def family_of(design: FilterDesign) -> PlantFamily:
    assert design.uncertainty is not None
    return PlantFamily.of(design, design.uncertainty)


def squared_gain(**changes: object) -> FilterDesign:
    """Return a cart whose input is multiplied by the square of a parameter: affine neither in it nor in one over it."""
    x, u, gain = ca.SX.sym("x", 2), ca.SX.sym("u"), Parameter.of("gain", 1.0)
    parts: dict[str, object] = {
        "system": System(x=x, u=u, f=ca.vertcat(x[1], -x[1] + gain.symbol**2 * u), y=x[1], parameters=(gain,)),
        "u_fb": -x[0],
        "fail_safe": -x[1],
        "barriers": (Barrier(name="wall", h=1 - x[0], class_k=gains(3.0, 3.0, 3.0)),),
        "passivity": paper_passivity(x),
        "mode": Mode.SAFE,
        "uncertainty": Uncertainty(parameters={"gain": (0.9, 1.1)}),
    }
    return paper_design(**(parts | changes))


def pushed(design: FilterDesign, **more: object) -> Decision:
    x = (-1.05, 0.0, 0.45, 0.0) if design.system.n == 4 else (0.9, 0.1)
    core, m = SafetyPassivityFilter(design), design.system.m
    return core.decide(x, (0.0,) * m, (20.0,) * m, (0.0,) * m, **more)  # type: ignore[arg-type]  # by name


def test_the_reciprocal_of_a_mass_takes_its_place() -> None:
    family = family_of(paper_design(uncertainty=Uncertainty(parameters={"mass": (0.8, 1.25), "sigma": (0.5, 2.0)})))
    mass, sigma = family.coordinates

    assert (mass.is_reciprocal, mass.is_affine, mass.low, mass.high) == (True, True, 0.8, 1.25)
    assert (sigma.is_reciprocal, sigma.is_affine, sigma.low, sigma.high) == (False, True, 0.5, 2.0)
    assert (mass.parameter_at(0.8), sigma.parameter_at(0.8)) == (1.25, 0.8)
    assert mass.distance(1.0) == pytest.approx(0.25)
    assert sigma.distance(1.0) == 1.0


def test_rows_are_at_the_ends_of_what_multiplies_the_input() -> None:
    both = Uncertainty(parameters={"mass": (0.8, 1.25), "sigma": (0.5, 2.0)})
    chains = SafetyPassivityFilter(paper_design(uncertainty=both)).chains

    assert [chain.barrier.name for chain in chains] == ["disk[mass=1.25]", "disk[mass=0.8]"]


def test_a_known_parameter_has_one_row() -> None:
    certain = Uncertainty(parameters={"mass": (1.0, 1.0)})
    chains = SafetyPassivityFilter(paper_design(uncertainty=certain)).chains
    assert [chain.barrier.name for chain in chains] == ["disk[mass=1]"]


def test_empty_sets_decide_as_the_model_does() -> None:
    design = paper_design(mode=Mode.SAFE)
    with_sets = pushed(replace(design, uncertainty=Uncertainty()))

    assert with_sets.u == pytest.approx(pushed(design).u, abs=1e-9)
    assert with_sets.status is Status.MODIFIED


def test_a_mass_brakes_at_its_worse_end() -> None:
    """u⁺ keeps the row of both ends: that of the heavy robot where it has to brake."""
    design = paper_design(mode=Mode.SAFE, between_samples=True)
    alone, sure = pushed(design), pushed(replace(design, uncertainty=MASS))
    assert sure.u[0] < alone.u[0] < 0
    assert sure.u[0] == pytest.approx(1.25 * alone.u[0], rel=0.02)


def test_a_square_is_bounded_over_the_trust_region() -> None:
    family = family_of(squared_gain())

    assert [each.is_affine for each in family.coordinates] == [False]
    assert [chain.barrier.name for chain in SafetyPassivityFilter(squared_gain()).chains] == ["wall"]
    assert pushed(squared_gain()).u[0] < pushed(squared_gain(uncertainty=None)).u[0]


def test_it_is_refused_where_it_acts_before_the_input() -> None:
    x, u, stiffness = ca.SX.sym("x", 3), ca.SX.sym("u"), Parameter.of("stiffness", 1.0)
    f = ca.vertcat(x[1], x[2] - ca.sin(stiffness.symbol * x[0]), u - x[2])
    design = squared_gain(
        system=System(x=x, u=u, f=f, y=x[1], parameters=(stiffness,)),
        u_fb=-x[0],
        fail_safe=-x[1],
        barriers=(Barrier(name="wall", h=1 - x[0], class_k=gains(3.0, 3.0, 3.0, 3.0)),),
        passivity=paper_passivity(x),
        uncertainty=Uncertainty(parameters={"stiffness": (0.9, 1.1)}),
    )
    with pytest.raises(DesignError, match="before the input acts"):
        SafetyPassivityFilter(design)


def test_a_lag_is_an_input_error() -> None:
    sets = Uncertainty(actuator_lag_s=0.1, input_error=(0.5, 0.0))
    design = paper_design(uncertainty=sets, input_rate_bound_per_s=(10.0, 20.0))
    assert family_of(design).input_error.full().ravel().tolist() == [1.5, 2.0]
    with_lag = pushed(
        replace(design, mode=Mode.SAFE, input_rate_bound_per_s=1e5, uncertainty=Uncertainty(input_error=(2.0, 0.0)))
    )
    assert with_lag.u[0] < pushed(paper_design(mode=Mode.SAFE)).u[0]


def test_a_maximum_has_rows_at_both_ends() -> None:
    base = paper_design()
    x = base.system.x
    either = Barrier(name="either", h=ca.fmax(-x[0], x[1] - 3), class_k=gains(5.0, 5.0, 5.0))
    design = paper_design(
        system=base.system,
        barriers=(either,),
        mode=Mode.SAFE,
        uncertainty=MASS,
        u_fb=-x[2:],
        fail_safe=-x[2:],
        passivity=paper_passivity(x),
    )
    core = SafetyPassivityFilter(design)
    assert [chain.barrier.name for chain in core.chains] == ["either[mass=1.25]", "either[mass=0.8]"]
    assert core.decide((-0.05, 0.0, 0.2, 0.0), ZERO, (20.0, 0.0), ZERO).status is Status.MODIFIED


def test_the_error_of_the_state_can_be_given() -> None:
    design = paper_design(mode=Mode.SAFE, uncertainty=Uncertainty(state_error=(1e-3, 1e-3, 1e-2, 1e-2)))
    by_default, wider = pushed(design), pushed(design, x_error=[2e-3, 1e-3, 0.02, 0.01])

    assert pushed(design, x_error=np.array([1e-3, 1e-3, 1e-2, 1e-2])).u == by_default.u
    assert wider.u[0] < by_default.u[0]
    assert wider.part("x_error").tolist() == [2e-3, 1e-3, 0.02, 0.01]


def test_an_error_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ShapeError, match="a design with uncertainty"):
        pushed(paper_design(), x_error=(0.1,) * 4)
    with pytest.raises(ShapeError, match="4 numbers"):
        pushed(paper_design(uncertainty=Uncertainty()), x_error=(0.1,))


def test_an_error_that_is_no_number_ends_in_the_fail_safe() -> None:
    decision = pushed(paper_design(uncertainty=Uncertainty()), x_error=(float("nan"),) * 4)
    assert decision.status is Status.UNCERTIFIED


def test_outside_of_the_set_rows_lead_back() -> None:
    design = paper_design(mode=Mode.SAFE, uncertainty=MASS)
    decision = SafetyPassivityFilter(design).decide((-0.95, 0.0, 0.0, 0.0), ZERO, (20.0, 0.0), ZERO)
    assert decision.u[0] < 0
    assert decision.status is Status.MODIFIED


def test_a_batch_decides_as_one_by_one() -> None:
    design = paper_design(mode=Mode.SAFE, uncertainty=replace(MASS, state_error=(1e-3, 1e-3, 1e-2, 1e-2)))
    core, rng = SafetyPassivityFilter(design), np.random.default_rng(4)
    x = np.array([-1.3, 0.0, 0.2, 0.0])[:, None] + rng.uniform(0, 0.1, (4, 6))
    u_h, error = rng.uniform(-20, 20, (2, 6)), rng.uniform(0, 0.02, (4, 6))
    batch = BatchFilter(core, 6)
    for x_error in (None, error):
        batch.decide(x, np.zeros((2, 6)), u_h, 0.0, x_error=x_error)
        for i in range(6):
            alone = core.decide(x[:, i], ZERO, u_h[:, i], ZERO, x_error=None if x_error is None else error[:, i])
            assert batch.evaluation.u_plus[:, i] == pytest.approx(alone.u, abs=1e-4)


def test_given_bounds_of_derivatives_are_refused() -> None:
    design = paper_design(uncertainty=MASS)
    family, core = family_of(design), SafetyPassivityFilter(design)
    zero_x, zero_u = ca.SX.zeros(4), ca.SX.zeros(2)
    row = replace(general_row(family.system, core.chains[0], 1e-3), change=object())
    with pytest.raises(DesignError, match="derivative_bounds"):
        member_bound(family, row, tube_of(family.motion(zero_x, zero_u), 1e-3), 1e-3, zero_x, zero_u)
