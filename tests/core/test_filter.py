from dataclasses import replace
from math import hypot

import numpy as np
import pytest
from core_designs import DESIGNS, PAPER_START, Builder, assert_consistent, paper_design, paper_passivity, random_state
from finite_differences import Array, numeric, rate_along

from passafe.decision import Status
from passafe.design import Law, Mode
from passafe.errors import DesignError
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.tank import Tank

ZERO = (0.0, 0.0)
LAWS_AND_MODES = [(law, mode) for law in Law for mode in Mode]


@pytest.mark.parametrize(("law", "mode"), LAWS_AND_MODES)
@pytest.mark.parametrize("build", DESIGNS)
def test_parts_of_a_decision_are_what_their_names_say(build: Builder, law: Law, mode: Mode) -> None:
    design = build(law=law, mode=mode)
    system = design.system
    made = SafetyPassivityFilter(design)
    psi = [numeric([system.x, system.u], one) for chain in made.chains for one in chain.psi]
    storage = numeric([system.x], design.passivity.V)
    output, flow = numeric([system.x], system.y), numeric([system.x, system.u], system.f)
    rng = np.random.default_rng(40)
    for _ in range(10):
        x, u, u_h, u_h_rate = (random_state(rng, size) for size in (system.n, *[system.m] * 3))
        decision = made.decide(list(x), list(u), list(5 * u_h), list(u_h_rate), 0.5)

        def rate(_: float, s: Array, held: tuple[float, ...] = decision.u) -> Array:
            return flow(s, held)

        assert_consistent(made, decision)
        assert decision.psi == pytest.approx([one(x, decision.u)[0] for one in psi])
        margin = output(x) @ decision.u - rate_along(storage, rate, x)[0]
        assert decision.power_margin == pytest.approx(margin, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(
    ("mode", "names"),
    [
        (Mode.OFF, ()),
        (Mode.SAFE, ("disk",)),
        (Mode.PASSIVE, ("passivity",)),
        (Mode.BOTH, ("disk", "passivity")),
    ],
)
@pytest.mark.parametrize("law", Law)
def test_each_mode_has_its_rows(law: Law, mode: Mode, names: tuple[str, ...]) -> None:
    made = SafetyPassivityFilter(paper_design(law=law, mode=mode))
    decision = made.decide(PAPER_START, ZERO, (-3.0, 0.0), ZERO)

    limits = ("input 0 low", "input 1 low", "input 0 high", "input 1 high")
    assert made.row_names == (*names, *limits)
    assert made.constraints == len(names)
    assert decision.margins.size == decision.duals.size == len(names) + 4
    assert decision.psi.size == 3  # reported in every mode


def test_without_rows_the_nominal_input_passes() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.OFF))
    decision = made.decide((0.0, 0.0, 0.0, 0.0), (1.0, 2.0), (-3.0, 5.0), (10.0, 20.0))

    # u + dt(u̇_h + k_i(u_h − u) − k_D u)
    assert decision.u == pytest.approx((1 + 1e-3 * (10 - 400 - 5), 2 + 1e-3 * (20 + 300 - 10)))
    assert (decision.status, decision.solver) == (Status.PASSED, "none")
    assert decision.v == pytest.approx([0, 0], abs=1e-9)


def test_one_active_row_is_met_exactly_by_the_nearest_input() -> None:
    """One row in closed form: u⁺ = u_ref − ψ₂(x, u_ref) g/‖g‖² with g = 2x₁."""
    made = SafetyPassivityFilter(paper_design(mode=Mode.SAFE, between_samples=False))
    decision = made.decide((1.2, 0.0, -1.0, 0.3), ZERO, ZERO, ZERO)
    g = np.array([2.4, 0.0])
    u_ref = decision.part("u_ref")
    psi_ref = 2 * (1 + 0.09) + 2 * 1.2 * (1 + u_ref[0]) + 20 * 2 * 1.2 * -1.0 + 100 * 0.44

    assert (decision.status, decision.solver) == (Status.MODIFIED, "piqp")
    assert psi_ref < 0
    assert decision.u == pytest.approx(u_ref - psi_ref * g / (g @ g), abs=1e-5)
    assert decision.psi[2] == pytest.approx(0.0, abs=1e-5)
    assert decision.margins[0] == pytest.approx(0.0, abs=1e-5)


def test_the_nominal_input_is_held_to_the_bound() -> None:
    made = SafetyPassivityFilter(paper_design(mode=Mode.OFF, input_bound=3.0))
    decision = made.decide((0.0, 0.0, 0.0, 0.0), (2.5, -2.5), (1e3, -1e3), ZERO)

    assert decision.u == (3.0, -3.0)
    assert decision.part("u_nominal").tolist() == [1e3, -1e3]


def test_slack_from_its_threshold_on_is_called_relaxed() -> None:
    """At x₂ = 0 and V̇ = yᵀu = 0 nothing helps; moving outward with a large V the row is bought off at its price."""
    for threshold, status in ((1e-3, Status.RELAXED), (1e3, Status.MODIFIED)):
        design = paper_design(mode=Mode.PASSIVE)
        cheap = replace(paper_passivity(design.system.x, slack_weight=1e-2), relaxed_above=threshold)
        decision = SafetyPassivityFilter(replace(design, passivity=cheap)).decide(
            (5.0, 0.0, 1.0, 0.0), ZERO, ZERO, ZERO
        )

        # One row −x₂ᵀw + δ ≥ −c: δ = −c/(1 + ρ‖x₂‖²) with c = h_u(x, u_ref)
        c = 2 - 2 * 5 - decision.part("u_ref")[0]
        assert decision.status is status
        assert decision.slack == pytest.approx(-c / (1 + 1e-2), rel=1e-4)
        assert decision.power_margin == pytest.approx(-decision.slack, rel=1e-4)


def test_the_tank_is_drawn_on_down_to_its_reserve() -> None:
    tank = Tank(initial_j=2.0, reserve_j=0.5, rate_per_s=4.0)
    plain = paper_design(mode=Mode.PASSIVE)
    full = SafetyPassivityFilter(replace(plain, passivity=paper_passivity(plain.system.x, tank=tank, slack_weight=1e6)))
    power = SafetyPassivityFilter(plain)
    x = np.array([5.0, 0.0, 1.0, 0.0])
    request = (x.tolist(), ZERO, ZERO, ZERO)

    for level in (0.25, 0.5, 0.75):
        decision = full.decide(*request, level)
        u = np.array(decision.u)
        a = u - x[2:]  # h_u = −x₂ᵀu − 2x₁ᵀx₂ + 2‖x₂‖², and what it loses in half a period has to be there, too
        falling = a @ u + 2 * x[2:] @ x[2:] + 2 * x[:2] @ a - 4 * x[2:] @ a
        margin = plain.dt_s / 2 * max(falling, 0.0)
        assert decision.power_margin == pytest.approx(-4.0 * (level - 0.5) + margin, abs=1e-3)
        assert power.decide(*request, level).u == power.decide(*request).u


def test_safety_is_never_paid_for_with_passivity() -> None:
    """Slowly outward near the disk, energy spent: safety holds to its tolerance, the passivity row pays."""
    made = SafetyPassivityFilter(paper_design())
    decision = made.decide((1.01, 0.0, -0.5, 0.0), (0.0, 0.0), (-50.0, 0.0), ZERO)

    assert decision.psi[2] >= -1e-4
    assert decision.status in {Status.MODIFIED, Status.RELAXED}
    assert_consistent(made, decision)


def test_continuous_rows_hold_along_a_clipped_applied_input() -> None:
    """d/dt ψ₂ + γ₃(ψ₂) ≥ 0 along u̇ = (u⁺ − u)/dt for every decision that is not a fallback."""
    design = paper_design(law=Law.CONTINUOUS, mode=Mode.SAFE, input_bound=20.0)
    made = SafetyPassivityFilter(design)
    psi_2 = numeric([design.system.x, design.system.u], made.chains[0].psi[-1])
    flow = numeric([design.system.x, design.system.u], design.system.f)
    clipped = 0
    for speed in np.linspace(1.0, 1.4, 41):
        x, u = np.array([1.1, 0.0, -speed, 0.0]), np.array([10.0, 0.0])
        decision = made.decide(list(x), list(u), (1000.0, 0.0), ZERO)
        if decision.status.is_fallback:
            continue
        clipped += bool(np.abs(decision.part("u_ref")).max() == 20.0)
        u_rate = (np.asarray(decision.u) - u) / design.dt_s

        def extended(_: float, s: Array, u_rate: Array = u_rate) -> Array:
            return np.concatenate([flow(s[:4], s[4:]), u_rate])

        rate = rate_along(lambda s: psi_2(s[:4], s[4:]), extended, np.concatenate([x, u]), 1e-6)[0]
        row = rate + 100 * psi_2(x, u)[0] ** 3

        assert row * design.dt_s / hypot(2.2, 0.0) >= -1e-3, f"at {speed} m/s, {decision.status.name}"
    assert clipped > 0


def test_underivable_design_is_refused_by_the_constructor() -> None:
    design = paper_design()
    disk = design.barriers[0]

    with pytest.raises(DesignError, match=r"barrier 'disk' class_k: got 2 functions, allowed 3"):
        SafetyPassivityFilter(replace(design, barriers=(replace(disk, class_k=disk.class_k[:2]),)))
    with pytest.raises(DesignError, match="storage V"):
        SafetyPassivityFilter(replace(design, passivity=Passivity(V=design.system.x)))
