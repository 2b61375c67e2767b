from collections.abc import Callable
from dataclasses import replace
from math import hypot, sqrt

import casadi as ca
import numpy as np
import pytest
from core_designs import DESIGNS, Builder, paper_design, paper_passivity, pump_design, random_state
from finite_differences import Array, numeric, rate_along, slope

from passafe.barrier_chain import derive_chain
from passafe.design import FilterDesign
from passafe.passivity import power_margin
from passafe.symbolic.enforced_passivity import EnforcedPassivity
from passafe.symbolic.rows import PASSIVITY_ROW, TINY, ConstraintRow, continuous_rows, row_at, stack
from passafe.symbolic.tracking import tracking_rate
from passafe.tank import Tank


def sampled_passivity_row(design: FilterDesign, u_ref: ca.SX, tank: ca.SX) -> ConstraintRow:
    """Return the sampled law's passivity row without a margin between samples."""
    enforced = EnforcedPassivity.of(replace(design, between_samples=False), tank)
    assert enforced is not None
    return enforced.row(u_ref, u_ref, ca.SX(0), ca.SX(0, 1))


class Derived:
    """The rows of one law on one design as functions of numbers, with the functions that they are derived from."""

    def __init__(self, design: FilterDesign, law: str) -> None:
        system = design.system
        self.n, self.m, self.dt_s = system.n, system.m, design.dt_s
        u_h, u_h_rate, tank = ca.SX.sym("u_h", self.m), ca.SX.sym("u_h_rate", self.m), ca.SX.sym("tank")
        u_ref = ca.SX.sym("u_ref", self.m)
        chains = [derive_chain(system, barrier) for barrier in design.barriers]
        h_u = power_margin(system, design.passivity.V)
        phi = tracking_rate(system, design.u_fb, u_h, u_h_rate, design.k_i)
        if law == "sampled":
            rows = [row_at(system, chain.barrier.name, chain.psi[-1], u_ref, u_ref) for chain in chains]
            rows.append(sampled_passivity_row(design, u_ref, tank))
        else:
            rows = continuous_rows(system, chains, h_u, design.passivity, phi, design.dt_s)
        given = [system.x, system.u, u_h, u_h_rate]
        self.rows = rows
        self.flow = numeric([system.x, system.u], system.f)
        self.phi = numeric(given, phi)
        self.values = [numeric([*given, u_ref, tank], row.value) for row in rows]
        self.gradients = [numeric([*given, u_ref, tank], row.gradient) for row in rows]
        functions = [*(chain.psi[-1] for chain in chains), h_u]
        class_k = [*(chain.last_class_k for chain in chains), design.passivity.class_k]
        self.functions = [numeric([system.x, system.u], function) for function in functions]
        self.gammas = [
            numeric([system.x, system.u], gamma(function)) for gamma, function in zip(class_k, functions, strict=True)
        ]


@pytest.mark.parametrize("build", DESIGNS)
def test_a_continuous_row_is_the_rate_of_its_function_plus_gamma(build: Builder) -> None:
    """Value + gradientᵀ(dt·v) = dt·(d/dt function + γ(function)) along ẋ = f(x, u), u̇ = φ + v."""
    derived = Derived(build(), "continuous")
    n, m = derived.n, derived.m
    rng = np.random.default_rng(6)
    for _ in range(15):
        x, u, u_h, u_h_rate, v = (random_state(rng, size) for size in (n, m, m, m, m))
        v *= 10

        def extended(t: float, s: Array, u_h: Array = u_h, u_h_rate: Array = u_h_rate, v: Array = v) -> Array:
            x, u = s[:n], s[n:]
            return np.concatenate([derived.flow(x, u), derived.phi(x, u, u_h + t * u_h_rate, u_h_rate) + v])

        for i, function in enumerate(derived.functions):
            given = (x, u, u_h, u_h_rate, np.zeros(m), 0.0)
            row = derived.values[i](*given) + derived.gradients[i](*given) @ v * derived.dt_s

            def along(s: Array, function: Callable[..., Array] = function) -> Array:
                return function(s[:n], s[n:])

            rate = rate_along(along, extended, np.concatenate([x, u]), 2e-4)
            assert row / derived.dt_s == pytest.approx(rate + derived.gammas[i](x, u), rel=1e-6, abs=1e-4)


@pytest.mark.parametrize("build", DESIGNS)
def test_a_sampled_row_is_its_function_at_the_next_input(build: Builder) -> None:
    design = build()
    derived = Derived(design, "sampled")
    tank = design.passivity.tank
    rng = np.random.default_rng(7)
    for _ in range(15):
        x, u, u_h, u_h_rate, u_ref = (random_state(rng, size) for size in (derived.n, *[derived.m] * 4))
        level = rng.uniform(0, 10)
        drawn = tank.rate_per_s * (level - tank.reserve_j) if tank else 0.0
        for i, function in enumerate(derived.functions):
            given = (x, u, u_h, u_h_rate, u_ref, level)
            allowance = drawn if derived.rows[i].name == PASSIVITY_ROW else 0.0

            def of_input(held: Array, function: Callable[..., Array] = function, x: Array = x) -> float:
                return float(function(x, held)[0])

            assert derived.values[i](*given) == pytest.approx(of_input(u_ref) + allowance, rel=1e-12, abs=1e-12)
            assert derived.gradients[i](*given) == pytest.approx(slope(of_input, u_ref), rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("build", [build for build in DESIGNS if build is not pump_design])
def test_sampled_row_affine_in_u_is_exact_for_every_input(build: Builder) -> None:
    derived = Derived(build(), "sampled")
    rng = np.random.default_rng(8)
    for _ in range(15):
        x, u, u_ref, w = (random_state(rng, size) for size in (derived.n, derived.m, derived.m, derived.m))
        given = (x, u, u, u, u_ref, 0.5)  # the default tank's reserve: nothing to draw
        for i, function in enumerate(derived.functions):
            row = derived.values[i](*given) + derived.gradients[i](*given) @ (100 * w)

            assert row == pytest.approx(function(x, u_ref + 100 * w), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("law", ["sampled", "continuous"])
def test_rows_have_names_and_only_sampled_passivity_is_soft(law: str) -> None:
    rows = Derived(paper_design(), law).rows

    assert [row.name for row in rows] == ["disk", "passivity"]
    assert [row.slack_price for row in rows] == [None, 1e4 if law == "sampled" else None]


def test_without_a_power_margin_there_is_no_passivity_row() -> None:
    design = paper_design()
    system = design.system
    chains = [derive_chain(system, barrier) for barrier in design.barriers]

    assert [row.name for row in continuous_rows(system, chains, None, None, system.u, 1e-3)] == ["disk"]


def test_a_tangent_touches_at_the_given_point() -> None:
    design = pump_design()
    system = design.system
    function = design.system.f[0] + ca.exp(system.u[0])
    u_ref, u_lin = ca.SX.sym("u_ref", system.m), ca.SX.sym("u_lin", system.m)
    row = row_at(system, "curved", function, u_ref, u_lin)
    value = numeric([system.x, u_ref, u_lin], row.value)
    gradient = numeric([system.x, u_ref, u_lin], row.gradient)
    curve = numeric([system.x, system.u], function)
    x, near = np.full(system.n, 0.3), np.full(system.m, 0.2)
    for far in (0.2, 0.9, -0.4):
        given = (x, np.full(system.m, far), near)

        assert value(*given) + gradient(*given) @ (near - far) == pytest.approx(curve(x, near)[0])


def test_tank_lends_above_its_reserve_and_reclaims_below() -> None:
    tank = Tank(initial_j=2.0, reserve_j=1.5, rate_per_s=4.0)
    plain = paper_design(barriers=())
    derived = Derived(replace(plain, passivity=paper_passivity(plain.system.x, tank=tank)), "sampled")
    state, zero = np.array([1.0, 2, 3, 4]), np.zeros(2)
    margin = derived.functions[0](state, zero)

    lent = [float((derived.values[0](state, zero, zero, zero, zero, level) - margin)[0]) for level in (2.0, 1.5, 0.5)]

    assert lent == pytest.approx([2.0, 0.0, -4.0])


def stacked(rows: list[tuple[float, tuple[float, ...], float | None]], reach: float) -> tuple[Array, Array, float]:
    """G, d and √ρ of rows given as (value, gradient, slack's price)."""
    made = [
        ConstraintRow(name=str(i), value=ca.SX(c), gradient=ca.SX(list(g)), slack_price=p)
        for i, (c, g, p) in enumerate(rows)
    ]
    G, d, root = stack(made, 2, reach)
    return ca.DM(ca.evalf(G)).full(), ca.DM(ca.evalf(d)).full().ravel(), root


def test_no_rows_stack_to_nothing() -> None:
    G, d, root = stack([], 2, 1.0)

    assert (G.shape, d.shape, root) == ((0, 2), (0, 1), 0.0)


def test_hard_rows_become_distances() -> None:
    G, d, root = stacked([(10.0, (3.0, 4.0), None), (-5.0, (0.0, -2.0), None)], reach=100.0)

    assert G.tolist() == [[0.6, 0.8], [0.0, -1.0]]
    assert d.tolist() == [-2.0, 2.5]
    assert root == 0.0


def test_a_soft_row_pays_its_price_in_the_last_entry() -> None:
    """C + gᵀw + δ ≥ 0 at ½ρδ² is the row over (w, √ρ·δ) at ½‖·‖²."""
    G, d, root = stacked([(-3.0, (1.0, 2.0), 16.0), (10.0, (3.0, 4.0), None)], reach=100.0)
    length = hypot(1.0, 2.0, 0.25)

    assert root == 4.0
    assert pytest.approx(np.array([[1 / length, 2 / length, 0.25 / length], [0.6, 0.8, 0.0]])) == G
    assert d == pytest.approx([3 / length, -2.0])
    w, delta = np.array([0.1, -0.2]), 3.5
    kept = G @ [*w, root * delta] - d
    assert kept * [length, 5.0] == pytest.approx([-3 + 0.1 - 0.4 + 3.5, 10 + 0.3 - 0.8])


def test_rows_out_of_reach_stay_kept_or_failing() -> None:
    """A hard row drawn in to the reach of w says the same as before about every ‖w‖ ≤ reach."""
    rng = np.random.default_rng(9)
    reach = 2 * 100.0 * sqrt(2)
    value, gradient = ca.SX.sym("c"), ca.SX.sym("g", 2)
    G, d, _ = stack([ConstraintRow(name="row", value=value, gradient=gradient)], 2, reach)
    row = numeric([value, gradient], ca.horzcat(G, d))
    verdicts = set()
    for _ in range(500):
        g = rng.normal(size=2) * 10 ** rng.uniform(-8, 8)
        c = rng.normal() * hypot(*g) * 10 ** rng.uniform(-2, 8)
        *unit, bound = row(c, g)
        w = rng.normal(size=2)
        w *= reach * rng.uniform() / hypot(*w)
        verdict = c + g @ w >= 0

        assert abs(bound) <= 2 * reach
        assert hypot(*unit) == pytest.approx(1.0)
        assert (unit @ w >= bound) == verdict
        verdicts.add((bool(verdict), abs(bound) == 2 * reach))
    assert len(verdicts) == 4


def test_bound_of_a_soft_row_is_not_drawn_in_from_above() -> None:
    _, d, _ = stacked([(-1e9, (1.0, 0.0), 1.0), (1e9, (1.0, 0.0), 1.0)], reach=10.0)

    assert d == pytest.approx([1e9 / sqrt(2), -20.0])


@pytest.mark.parametrize("length", [0.0, TINY / 4, 5e-324])
def test_a_row_without_gradient_is_kept_or_failing_whatever_u_is(length: float) -> None:
    G, d, _ = stacked(
        [(1e-3, (length, 0.0), None), (-1e-3, (length, 0.0), None), (0.0, (length, 0.0), None)], reach=10.0
    )

    assert np.abs(G).max() <= 0.25
    assert d.tolist() == [-20.0, 20.0, 0.0]
