import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, drag_design, gains, jerk_design, pump_design, random_state
from finite_differences import Array, numeric, rate_along

from passafe.barrier_chain import Barrier, derive_chain, derive_chains
from passafe.class_k import Cubic, Linear
from passafe.errors import DesignError, RelativeDegreeError, ShapeError
from passafe.system import System

x = ca.SX.sym("x", 3)
u = ca.SX.sym("u")
TRIPLE = System(x=x, u=u, f=ca.vertcat(x[1], x[2], u), y=x[1])


def barrier(h: ca.SX, count: int) -> Barrier:
    return Barrier(name="limit", h=h, class_k=gains(*(1.0 + i for i in range(count))))


@pytest.mark.parametrize("build", DESIGNS)
def test_each_psi_is_the_rate_of_the_one_before_plus_gamma(build: Builder) -> None:
    design = build()
    system = design.system
    rng = np.random.default_rng(2)
    flow = numeric([system.x, system.u], system.f)
    for chain in (derive_chain(system, one) for one in design.barriers):
        for i in range(1, len(chain.psi)):
            before = numeric([system.x], chain.psi[i - 1])
            gamma = numeric([system.x], chain.barrier.class_k[i - 1](chain.psi[i - 1]))
            psi = numeric([system.x, system.u], chain.psi[i])
            for _ in range(20):
                state, held = random_state(rng, system.n), random_state(rng, system.m)

                def rate(_: float, s: Array, held: Array = held) -> Array:
                    return flow(s, held)

                expected = rate_along(before, rate, state) + gamma(state)

                assert psi(state, held) == pytest.approx(expected, rel=1e-7, abs=1e-6)


@pytest.mark.parametrize(
    ("build", "degree", "last"), [(pump_design, 1, 2.5), (drag_design, 2, 4.0), (jerk_design, 3, 4.0)]
)
def test_finds_relative_degrees(build: Builder, degree: int, last: float) -> None:
    design = build()
    chain = derive_chain(design.system, design.barriers[0])

    assert chain.relative_degree == degree
    assert [ca.which_depends(psi, design.system.u) for psi in chain.psi[:-1]] == [[False] * design.system.m] * degree
    assert any(ca.which_depends(chain.psi[-1], design.system.u))
    assert chain.last_class_k is chain.barrier.class_k[degree]
    assert chain.last_class_k.gain == last


@pytest.mark.parametrize(("h", "degree"), [(x[2] + x[0], 1), (x[1] + x[0], 2), (x[0], 3)])
def test_the_shortest_way_of_the_input_counts(h: ca.SX, degree: int) -> None:
    assert derive_chain(TRIPLE, barrier(h, degree + 1)).relative_degree == degree


def test_gamma_acts_on_the_psi_before_it() -> None:
    chain = derive_chain(
        TRIPLE, Barrier(name="limit", h=x[1], class_k=(Cubic(gain=2.0), Linear(gain=3.0), Linear(gain=4.0)))
    )
    psi = numeric([x, u], ca.vertcat(*chain.psi))

    # ψ₀ = x₁, ψ₁ = x₂ + 2x₁³, ψ₂ = u + 6x₁²x₂ + 3ψ₁
    assert psi([0, 2, 5], 7).tolist() == [2.0, 5 + 2 * 8, 7 + 6 * 4 * 5 + 3 * 21]


@pytest.mark.parametrize("count", [0, 1, 2, 3, 5])
def test_chain_needs_one_class_k_more_than_its_relative_degree(count: int) -> None:
    with pytest.raises(DesignError) as refused:
        derive_chain(TRIPLE, barrier(x[0], count))

    assert str(refused.value) == (
        f"barrier 'limit' class_k: got {count} functions, allowed 4: relative degree 3 and one more"
    )


@pytest.mark.parametrize("count", [0, 2, 4, 9])
def test_a_barrier_that_the_input_never_reaches_is_refused(count: int) -> None:
    stuck = System(x=x, u=u, f=ca.vertcat(x[1], -x[0], u), y=x[2])

    with pytest.raises(RelativeDegreeError) as refused:
        derive_chain(stuck, barrier(x[0] ** 2, count))

    assert (refused.value.barrier, refused.value.tried, refused.value.is_contained) == ("limit", 3, False)
    assert "do not contain the input" in str(refused.value)


def test_a_barrier_that_is_flat_nearly_everywhere_is_said_to_be() -> None:
    with pytest.raises(RelativeDegreeError) as refused:
        derive_chain(TRIPLE, barrier(ca.tanh(1e4 * (x[0] - 123)), 4))

    assert refused.value.is_contained
    assert "contain the input, but it has no effect at any state tried" in str(refused.value)


def test_a_constant_barrier_has_no_relative_degree() -> None:
    with pytest.raises(RelativeDegreeError):
        derive_chain(TRIPLE, barrier(ca.SX(1.0), 2))


def test_an_input_that_cancels_does_not_count() -> None:
    nothing = (x[0] + 1) * u - x[0] * u - u
    assert ca.jacobian(nothing, u).nnz() == 1  # still there for anyone who looks at the structure alone
    system = System(x=x, u=u, f=ca.vertcat(x[1] + nothing, x[2], u), y=x[1])
    stuck = System(x=x, u=u, f=ca.vertcat(x[1] + nothing, -x[0], u), y=x[1])

    assert derive_chain(system, barrier(x[0], 4)).relative_degree == 3
    with pytest.raises(RelativeDegreeError):
        derive_chain(stuck, barrier(x[0], 4))


@pytest.mark.parametrize("h", [x[0] * x[1], (x[0] - 0.37) * (x[0] + 0.48)])
def test_input_with_isolated_zeros_of_its_effect_counts(h: ca.SX) -> None:
    system = System(x=x, u=u, f=ca.vertcat(u, x[2], x[0]), y=x[1])

    assert derive_chain(system, barrier(h, 2)).relative_degree == 1


@pytest.mark.parametrize("h", [ca.log(x[2] - 5), ca.sqrt(x[2] - 20) - 1, ca.fmin(40 - x[2], 1)])
def test_a_barrier_counts_wherever_it_is_defined(h: ca.SX) -> None:
    assert derive_chain(TRIPLE, barrier(h, 2)).relative_degree == 1


@pytest.mark.parametrize(
    "h",
    [
        2 - ca.sqrt(x[0] * x[1]),
        2 - ca.sqrt(x[0]) - ca.sqrt(x[1]),
        3 - ca.sqrt(x[0] ** 2 - x[1] ** 2),
        ca.sqrt(1 - 1e4 * ca.sumsqr(x[:2])),
        9 - ca.sqrt(x[0] - 1000),
    ],
)
def test_a_barrier_that_is_defined_in_few_places_counts(h: ca.SX) -> None:
    """None of these is a number where the signs of neighbouring states differ, or at sizes from 0.1 to 300."""
    system = System(x=x, u=u, f=ca.vertcat(x[1], u, -x[2]), y=x[1])

    assert derive_chain(system, barrier(h, 2 if ca.depends_on(h, x[1]) else 3)).relative_degree >= 1


def test_a_barrier_that_is_defined_nowhere_is_refused() -> None:
    with pytest.raises(RelativeDegreeError):
        derive_chain(TRIPLE, barrier(ca.sqrt(-1 - x[2] ** 2), 2))


def test_a_barrier_is_a_scalar_function_of_the_state() -> None:
    with pytest.raises(ShapeError, match=r"barrier 'limit' h: got shape \(3, 1\), allowed shape \(1, 1\)"):
        derive_chain(TRIPLE, barrier(x, 2))
    with pytest.raises(DesignError, match=r"barrier 'limit' h: got the symbols \['u'\]"):
        derive_chain(TRIPLE, barrier(x[0] + u, 2))


def test_chain_of_a_moving_set_includes_the_time_derivative() -> None:
    centre = ca.vertcat(2 * ca.sin(3 * TRIPLE.t), 0.5 * TRIPLE.t**2, 0.0)
    moving = Barrier(name="moving", h=ca.sumsqr(TRIPLE.x - centre) - 1, class_k=gains(1.0, 2.0))
    chain = derive_chain(TRIPLE, moving)
    clocked = ca.vertcat(TRIPLE.x, TRIPLE.t)
    value = numeric([clocked, TRIPLE.u], chain.psi[0])
    slope = numeric([clocked, TRIPLE.u], chain.psi[1] - moving.class_k[0](chain.psi[0]))
    flow = numeric([clocked, TRIPLE.u], ca.vertcat(TRIPLE.f, 1))
    rng = np.random.default_rng(5)
    for _ in range(20):
        state, held = random_state(rng, 4), random_state(rng, 1)

        measured = rate_along(lambda s: value(s, held), lambda _, s: flow(s, held), state)  # noqa: B023 - used at once

        assert chain.relative_degree == 1
        assert slope(state, held) == pytest.approx(measured, rel=1e-6, abs=1e-6)


def test_time_belongs_to_barriers_alone() -> None:
    with pytest.raises(DesignError, match="system f: got the symbols"):
        System(x=x, u=u, f=ca.vertcat(x[1], x[2], u + TRIPLE.t), y=x[1], t=TRIPLE.t)
    with pytest.raises(DesignError, match="symbols"):
        TRIPLE.require_state_function("V", TRIPLE.t * x[0], 1)


def test_turned_coordinates_leave_no_rounding_of_u() -> None:
    """ẋ = S(v, u) with Sᵀx = (p, v): h = 1 − p has degree 2, and ψ₁ = −v + 2(1 − p), however S rounds."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
    cosine, sine = ca.cos(ca.DM(0.3)), ca.sin(ca.DM(0.3))
    turn = ca.vertcat(ca.horzcat(cosine, -sine), ca.horzcat(sine, cosine))
    p, v = ca.vertsplit(turn.T @ x)
    system = System(x=x, u=u, f=turn @ ca.vertcat(v, u), y=v)
    chain = derive_chain(system, Barrier(name="wall", h=1 - p, class_k=(Linear(gain=2.0),) * 3))
    psi_1 = ca.Function("psi_1", [x], [chain.psi[1]])  # refused if u were in it

    assert chain.relative_degree == 2
    assert float(psi_1(turn @ ca.DM([0.25, 0.5]))) == pytest.approx(1.0)


def two_paths(direct: float, actuator: float = 1.0) -> System:
    """Return ẋ₀ = x₁ + direct·u, ẋ₁ = actuator·u."""
    s, v = ca.SX.sym("s", 2), ca.SX.sym("v")
    return System(x=s, u=v, f=ca.vertcat(s[1] + direct * v, actuator * v), y=s[1])


@pytest.mark.parametrize("direct", [1e-9, -3e-11, 1e-12])
@pytest.mark.parametrize("count", [2, 3])
def test_a_degree_that_rests_on_next_to_nothing_is_refused(direct: float, count: int) -> None:
    system = two_paths(direct)

    with pytest.raises(DesignError, match="a relative degree of 1 by formula, of 2 or more in effect"):
        derive_chain(system, Barrier(name="limit", h=system.x[0], class_k=gains(*(5.0,) * count)))


@pytest.mark.parametrize("unit", [1e-12, 1.0, 1e12])
def test_relative_degree_does_not_depend_on_units(unit: float) -> None:
    weak, strong = two_paths(0.0, unit), two_paths(0.5 * unit, unit)

    assert derive_chain(weak, Barrier(name="limit", h=weak.x[0] / unit, class_k=gains(5, 5, 5))).relative_degree == 2
    assert derive_chain(strong, Barrier(name="limit", h=unit * strong.x[0], class_k=gains(5, 5))).relative_degree == 1


def test_a_weak_path_that_is_not_nothing_is_in_doubt() -> None:
    system = two_paths(1e-5)
    reach = derive_chain(system, Barrier(name="limit", h=system.x[0], class_k=gains(5, 5))).reach

    assert (reach.degree, reach.how, reach.is_doubtful, reach.is_too_weak) == (1, "structure", True, False)
    assert reach.ratio == pytest.approx(2 * 5 * 1e-5)


def test_numbers_that_do_not_cancel_to_the_last_bit_do_not_count() -> None:
    system = two_paths(0.1 + 0.2 - 0.3)
    assert ca.jacobian(system.f[0], system.u).nnz() == 1

    assert derive_chain(system, Barrier(name="limit", h=system.x[0], class_k=gains(5, 5, 5))).relative_degree == 2


def test_a_path_that_depends_on_the_state_is_found_by_values() -> None:
    system = System(x=x, u=u, f=ca.vertcat(x[1] * u, x[2], u), y=x[1])

    assert derive_chain(system, barrier(x[0], 2)).reach.how == "values"


@pytest.mark.parametrize("zone", [0.5, 3.0, 40.0])
@pytest.mark.parametrize("ceiling", [1.5, 100.0])
def test_a_dead_zone_hides_no_input(zone: float, ceiling: float) -> None:
    """Find the degree, though small inputs have no effect and those beyond the saturation none again."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    force = ca.fmin(ca.fmax(u - zone, 0), ceiling * zone) + ca.fmax(ca.fmin(u + zone, 0), -ceiling * zone)
    system = System(x=x, u=u, f=ca.vertcat(x[1], force), y=x[1])

    assert derive_chain(system, Barrier(name="wall", h=1 - x[0], class_k=gains(2.0, 2.0, 2.0))).relative_degree == 2


def test_an_input_that_never_leaves_its_dead_zone_is_none() -> None:
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], ca.fmax(u - 1e200, 0)), y=x[1])

    with pytest.raises(DesignError, match="barrier 'wall'"):
        derive_chain(system, Barrier(name="wall", h=1 - x[0], class_k=gains(2.0, 2.0, 2.0)))


def test_parts_of_a_minimum_take_as_many_functions_as_they_need() -> None:
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1])
    place, speed = derive_chains(
        system, Barrier(name="calm", h=ca.fmin(1 - x[0], 1 - x[1]), class_k=gains(2.0, 3.0, 4.0))
    )

    assert (place.relative_degree, speed.relative_degree) == (2, 1)
    assert speed.barrier.class_k == gains(2.0, 3.0)
    with pytest.raises(DesignError, match="got 4 functions, allowed 3"):
        derive_chains(system, Barrier(name="calm", h=ca.fmin(1 - x[0], 1 - x[1]), class_k=gains(2.0, 3.0, 4.0, 5.0)))


@pytest.mark.parametrize("count", [2, 3])
def test_branches_of_a_maximum_have_one_relative_degree(count: int) -> None:
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    system = System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1])

    with pytest.raises(DesignError, match=r"class_k: got 2|a maximum of branches of relative degrees"):
        derive_chains(system, Barrier(name="either", h=ca.fmax(1 - x[0], 1 - x[1]), class_k=gains(*(2.0,) * count)))
