import casadi as ca
import numpy as np
import pytest
from core_designs import (
    DESIGNS,
    Builder,
    gains,
    paper_design,
    paper_passivity,
    random_state,
    row_filter,
    row_state,
)

from passafe.barrier_chain import Barrier
from passafe.barriers import half_plane
from passafe.decision import Decision, Status
from passafe.design import Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.override import Explainer, Override, OverrideCause

TOLERANCE = 1e-6
NO_RATE = (0.0, 0.0)


def made(
    rows: list[tuple[float, float, float]],
    u_h: tuple[float, float],
    *,
    soft: bool = False,
    bound: float = 100.0,
    u: tuple[float, float] = (0.0, 0.0),
    u_h_rate: tuple[float, float] = NO_RATE,
    start: bool = True,
) -> tuple[Decision, Override]:
    """Decide with rows gᵀu + c ≥ 0 and explain it; u_fb = 0, so that at the start u_want = u_h."""
    core = row_filter(hard=len(rows) - soft, soft=soft, input_bound=bound)
    state = row_state(rows[:-1] + [(0.0, 0.0, 1.0)] * (3 - len(rows)) + rows[-1:] if soft else rows)
    decision = core.decide(state, u, u_h, u_h_rate, start=start)
    return decision, Explainer(core).override(decision)


def test_a_request_that_passes_is_not_overridden() -> None:
    decision, override = made([(1.0, 0.0, 5.0)], (-3.0, 1.0))

    assert decision.status is Status.PASSED
    assert (override.size, override.causes) == (0.0, ())
    assert (override.allowed_fraction, override.unavoidable) == (1.0, False)


def test_one_row_holds_back_what_is_beyond_it() -> None:
    # u₁ ≥ −2 with u_h = (−8, 3): the nearest input is (−2, 3), and a quarter of the command reaches −2.
    _, override = made([(2.0, 0.0, 4.0)], (-8.0, 3.0))

    assert override.change == pytest.approx([6.0, 0.0], abs=1e-5)
    assert override.held_back == pytest.approx([6.0, 0.0], abs=1e-5)
    assert override.size == pytest.approx(6.0, abs=1e-5)
    [cause] = override.causes
    assert (cause.row, cause.push, cause.share) == ("row 0", pytest.approx(6.0, abs=1e-5), pytest.approx(1.0))
    assert override.allowed_fraction == pytest.approx(0.25, abs=TOLERANCE)


def test_the_larger_share_comes_first_and_shares_sum_to_one() -> None:
    # u₁ ≥ 0 and u₂ ≥ 0 with u_h = (−1, −3): change (1, 3), shares 1/10 and 9/10.
    _, override = made([(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)], (-1.0, -3.0))

    assert [cause.row for cause in override.causes] == ["row 1", "row 0"]
    assert [cause.share for cause in override.causes] == pytest.approx([0.9, 0.1], abs=1e-5)


def test_a_row_that_the_other_pushes_into_has_a_negative_share() -> None:
    # u₂ ≥ 1 moves (0.1, 0) to (0.1, 1); −u₁ − 3u₂ ≥ −3 then takes u₁ to 0: change (−0.1, 1).
    _, override = made([(0.0, 1.0, -1.0), (-1.0, -3.0, 3.0)], (0.1, 0.0))

    assert override.change == pytest.approx([-0.1, 1.0], abs=1e-5)
    assert override.causes[0].share == pytest.approx(1.3 / 1.01, abs=1e-4)  # λ = (1.3, 0.1·√10)
    assert override.causes[1].share == pytest.approx(-0.29 / 1.01, abs=1e-4)


def test_a_limit_that_cuts_off_the_request_is_a_cause() -> None:
    decision, override = made([(1.0, 0.0, 50.0)], (-8.0, 3.0), bound=2.0)

    assert decision.status is Status.PASSED
    assert override.causes == (
        OverrideCause(row="input 0 low", push=6.0, share=pytest.approx(36 / 37)),
        OverrideCause(row="input 1 high", push=1.0, share=pytest.approx(1 / 37)),
    )
    assert override.allowed_fraction == pytest.approx(0.25, abs=TOLERANCE)


def test_held_back_command_would_have_passed_unchanged() -> None:
    rows, u_h = [(1.0, 0.0, 2.0)], np.array([-30.0, 3.0])
    u = (-1.99, 0.0)  # k = dt·k_i = 1e-3: u_want = −1.99 − 0.001·28.01

    decision, override = made(rows, tuple(u_h), u=u, start=False)
    other, unchanged = made(rows, tuple(u_h + override.held_back), u=u, start=False)

    assert override.change == pytest.approx([0.01801, 0.0], abs=1e-8 + TOLERANCE)
    assert override.held_back == pytest.approx(1000 * override.change)
    assert unchanged.size <= 1000 * TOLERANCE * 2
    assert other.u == pytest.approx(decision.u, abs=2 * TOLERANCE)


def test_the_rate_of_the_command_shrinks_with_it() -> None:
    # u_want = s·(k·u_h + dt·u̇_h) = s·(−0.004 − 0.004), and −0.002 is allowed.
    _, override = made([(1.0, 0.0, 0.002)], (-4.0, 0.0), u_h_rate=(-4.0, 0.0), start=False)

    assert override.allowed_fraction == pytest.approx(0.25, abs=2 * TOLERANCE / 0.008)


def test_a_smaller_command_may_be_the_one_that_does_not_pass() -> None:
    # u₁ ≥ 2 passes with (4, 0) and from half of it on.
    _, whole = made([(1.0, 0.0, -2.0)], (4.0, 0.0))
    # 2 ≤ u₁ ≤ 3 with (4, 0): three quarters are the most; half the least.
    _, between = made([(1.0, 0.0, -2.0), (-1.0, 0.0, 3.0)], (4.0, 0.0))

    assert (whole.allowed_fraction, whole.unavoidable) == (1.0, False)
    assert between.allowed_fraction == pytest.approx(0.75, abs=TOLERANCE)


@pytest.mark.parametrize("u_h", [(1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (-1.0, 0.0)])
def test_where_no_part_of_the_command_passes_that_is_said(u_h: tuple[float, float]) -> None:
    _, override = made([(1.0, 0.0, -2.0)], u_h)

    assert (override.allowed_fraction, override.unavoidable) == (0.0, True)


def test_command_with_an_overflowing_square_allows_nothing() -> None:
    _, override = made([(1.0, 0.0, 0.0)], (-1.2e154, 0.0))

    assert (override.allowed_fraction, override.unavoidable) == (0.0, True)


def test_zero_allowed_fraction_need_not_be_unavoidable() -> None:
    _, override = made([(1.0, 0.0, 0.0)], (-1.0, 0.0))

    assert override.allowed_fraction == pytest.approx(0.0, abs=2 * TOLERANCE)
    assert not override.unavoidable


def test_the_passivity_row_counts_without_its_slack() -> None:
    # u₁ ≥ −1 is soft; the command (−2, 0) passes by half.
    decision, override = made([(1.0, 0.0, 1.0)], (-2.0, 0.0), soft=True)

    assert decision.status is not Status.PASSED
    assert [cause.row for cause in override.causes] == ["passivity"]
    assert override.allowed_fraction == pytest.approx(0.5, abs=TOLERANCE)


def test_the_norm_s_limit_is_a_row_too() -> None:
    core = SafetyPassivityFilter(paper_design(mode=Mode.OFF, input_norm_bound=5.0, u_fb=ca.SX.zeros(2)))
    explain = Explainer(core).override

    def asked(u_h: tuple[float, float]) -> Override:
        return explain(core.decide((2.0, 2.0, 0.0, 0.0), (0.0, 0.0), u_h, NO_RATE, start=True))

    beyond, within, none = asked((6.0, 8.0)), asked((3.0, 4.0)), asked((0.0, 0.0))
    tolerated = 5.0 + core.design.tolerance.residual
    assert beyond.change == pytest.approx([-3.0, -4.0], abs=1e-5)
    assert beyond.allowed_fraction == pytest.approx(tolerated / 10.0, abs=1e-12)
    assert sum(cause.share for cause in beyond.causes) == pytest.approx(1.0, abs=1e-5)
    assert {cause.row.split()[0] for cause in beyond.causes} <= {"norm", "input"}
    assert (within.allowed_fraction, none.allowed_fraction) == (1.0, 1.0)


@pytest.mark.parametrize("u_h", [(0.0, 0.0), (0.0, 8.0)])
def test_beyond_the_norm_without_a_way_back_it_is_unavoidable(u_h: tuple[float, float]) -> None:
    core = SafetyPassivityFilter(paper_design(mode=Mode.OFF, input_norm_bound=5.0))
    # u_fb = (−20, 0) alone is longer than 5, and nothing that u_h adds across makes it shorter.
    decision = core.decide((2.0, 0.0, 0.0, 0.0), (0.0, 0.0), u_h, NO_RATE, start=True)

    assert Explainer(core).override(decision).unavoidable


def before_a_wall(wall_m: float, command: float) -> Override:
    """Explain at p₁ = 2, where u_want = −20 + s·command; the norm asks for |u₁| ≤ 5, a wall for u₁ ≤ 100·(wall − 2)."""
    robot = damped_point(sigma=1.0)
    h = half_plane(robot.position, normal=(-1.0, 0.0), offset=-wall_m)
    core = SafetyPassivityFilter(
        paper_design(
            system=robot.system,
            u_fb=-10 * robot.position,
            fail_safe=robot.fail_safe,
            barriers=(Barrier(name="wall", h=h, class_k=gains(10, 10, 10)),),
            passivity=paper_passivity(robot.system.x),
            mode=Mode.SAFE,
            input_norm_bound=5.0,
            between_samples=False,
        )
    )
    return Explainer(core).override(core.decide((2.0, 0.0, 0.0, 0.0), (0.0, 0.0), (command, 0.0), NO_RATE, start=True))


def test_norm_and_row_without_common_command_are_unavoidable() -> None:
    assert before_a_wall(1.9, 16.0).unavoidable  # u₁ ≤ −10, s ≤ 10/16; u₁ ≥ −5, s ≥ 15/16


def test_what_the_norm_allows_a_row_may_narrow() -> None:
    assert before_a_wall(2.02, 24.0).allowed_fraction == pytest.approx(22 / 24, abs=TOLERANCE)  # u₁ ≤ 2; −5 ≤ u₁ ≤ 5


@pytest.mark.parametrize("builder", DESIGNS)
@pytest.mark.parametrize("law", Law)
def test_filter_passes_the_allowed_fraction_and_no_more(builder: Builder, law: Law) -> None:
    core = SafetyPassivityFilter(builder(law=law, between_samples=False))
    explain, system = Explainer(core).override, core.design.system
    rng = np.random.default_rng(7)
    seen = 0
    for _ in range(300):
        x, u = random_state(rng, system.n), random_state(rng, system.m, 3.0)
        u_h, rate = random_state(rng, system.m, 60.0), random_state(rng, system.m, 60.0)
        decision = core.decide(x, u, u_h, rate, 0.7)
        override = explain(decision)
        s = override.allowed_fraction
        shares = sum(cause.share for cause in override.causes)
        assert override.size < 1e-2 or decision.status is Status.UNCERTIFIED or shares == pytest.approx(1.0, abs=1e-3)
        if builder is DESIGNS[3]:  # not affine in u: the rows are other ones for another command
            continue
        passed = explain(core.decide(x, u, s * u_h, s * rate, 0.7))
        assert override.unavoidable or np.abs(passed.change).max() <= 1e-3  # √(2·gap)
        if 0.0 < s < 1.0:
            seen += 1
            larger = explain(core.decide(x, u, (s + 0.01) * u_h, (s + 0.01) * rate, 0.7))
            assert np.abs(larger.change).max() > 1e-6
    assert seen or builder is DESIGNS[3]


def test_fail_safe_law_and_nan_have_no_causes() -> None:
    core = SafetyPassivityFilter(paper_design())
    nan = float("nan")

    for u_h in ((nan, 0.0), (float("inf"), 0.0), (1e300, -1e300)):
        decision = core.decide((2.0, 2.0, -1.0, -1.0), (0.0, 0.0), u_h, NO_RATE)
        override = Explainer(core).override(decision)
        assert (override.allowed_fraction, override.unavoidable) == (0.0, True)
    decision = core.decide((nan, 2.0, -1.0, -1.0), (0.0, 0.0), (1.0, 0.0), NO_RATE)
    assert decision.status is Status.UNCERTIFIED
    assert Explainer(core).override(decision).causes == ()


def test_one_without_rows_has_limits_still() -> None:
    core = SafetyPassivityFilter(paper_design(mode=Mode.OFF))
    decision = core.decide((0.0, 0.0, 0.0, 0.0), (0.0, 0.0), (400.0, 0.0), NO_RATE, start=True)
    override = Explainer(core).override(decision)

    assert override.allowed_fraction == pytest.approx(0.25, abs=TOLERANCE)
    assert override.causes == (OverrideCause(row="input 0 high", push=300.0, share=1.0),)


def test_many_decisions_are_explained_as_each_of_them() -> None:
    core = row_filter(hard=1, soft=False)
    explainer = Explainer(core)
    state = row_state([(2.0, 0.0, 4.0)])
    decisions = [core.decide(state, (0.0, 0.0), (push, 3.0), NO_RATE, start=True) for push in (-8.0, -3.0)]
    overrides = [explainer.override(decision) for decision in decisions]

    found = explainer.explain(np.array([decision.block for decision in decisions]))

    assert found.change.tolist() == [override.change.tolist() for override in overrides]
    assert found.held_back.tolist() == [override.held_back.tolist() for override in overrides]
