"""Many decisions at once are the filter's own, one by one."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from math import inf, nan

import numpy as np
import pytest
from core_designs import (
    damped_design,
    drag_design,
    jerk_design,
    paper_design,
    pump_design,
    row_filter,
    row_state,
)
from random_programs import unit
from random_requests import requests_of

from passafe.batch.batch_filter import BatchFilter
from passafe.decision import Decision, Status
from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array
from passafe.tank import Tank

AGREEMENT = 1e-4
"""By how much inputs may differ, relative to 1 + ‖z‖: two answers that pass the certificate, of which one may have been
solved by an interior-point method."""

DAMPED = damped_design()
DESIGNS: dict[str, FilterDesign] = {
    "relative degree 2, linear": damped_design(),
    "relative degree 2, nonlinear": drag_design(),
    "relative degree 3": jerk_design(),
    "relative degree 1, not affine in u": pump_design(),
    "a tank": replace(DAMPED, passivity=replace(DAMPED.passivity, tank=Tank()), input_bound=30.0),
    "limits that bind": damped_design(input_bound=(6.0, 9.0), input_rate_bound_per_s=2000.0),
    "a limit on the norm": damped_design(input_bound=20.0, input_norm_bound=12.0),
    "tangents at once": drag_design(between_samples=False),
    "the continuous law": damped_design(law=Law.CONTINUOUS),
    "safety alone": damped_design(mode=Mode.SAFE),
    "passivity alone": damped_design(mode=Mode.PASSIVE),
    "no constraint": damped_design(mode=Mode.OFF),
}

Request = tuple[Array, Array, Array, Array, Array, Array]


def requests(design: FilterDesign, count: int, seed: int) -> Request:
    """Random ones, a column each, from quiet to far beyond every limit."""
    rng = np.random.default_rng(seed)
    n, m = design.system.n, design.system.m
    scale = 10 ** rng.uniform(-1.5, 0.6, count)
    bound = np.array(design.limits.magnitude)[:, None]
    return (
        rng.normal(size=(n, count)) * scale,
        rng.uniform(-1.0, 1.0, (m, count)) * bound * rng.choice([0.0, 0.3, 1.0], count),
        rng.normal(size=(m, count)) * bound * rng.choice([0.0, 0.1, 2.0], count),
        rng.normal(size=(m, count)) * rng.choice([0.0, 10.0], count),
        rng.uniform(0.0, 1.0, count),
        rng.uniform(0.0, 5.0, count),
    )


def one_by_one(core: SafetyPassivityFilter, asked: Request, *, start: bool = False) -> list[Decision]:
    x, u, u_h, u_h_rate, tank_j, t_s = asked
    return [
        core.decide(*(each[:, i].tolist() for each in (x, u, u_h, u_h_rate)), tank_j[i], t_s[i], start=start)
        for i in range(x.shape[1])
    ]


def assert_same(many: BatchFilter, expected: Sequence[Decision]) -> None:
    """Check for the same decisions, to the last bit where the filter itself took them."""
    relaxed_above = many.core.design.passivity.relaxed_above
    for element, decision in enumerate(expected):
        status = Status(many.status[element])
        if many.scalar[element]:
            assert status is decision.status
            np.testing.assert_array_equal(many.batch.block[:, element], decision.block)
            continue
        scale = 1 + float(np.linalg.norm(decision.part("z")))
        for name in ("u_plus", "z", "margins"):
            assert many.part(name)[:, element] == pytest.approx(decision.part(name), abs=AGREEMENT * scale), name
        for name in ("x", "u", "u_h", "u_h_rate", "tank", "t", "start", "u_lin", "trust_asked", "tightening"):
            assert many.part(name)[:, element].tolist() == decision.part(name).tolist(), name
        for name in (
            "u_nominal",
            "phi",
            "u_ref",
            "low",
            "high",
            "trust",
            "deviation",
            "power_deviation",
            "G",
            "d",
            "relax",
            "cuts",
        ):
            assert many.part(name)[:, element] == pytest.approx(decision.part(name), rel=1e-11, abs=1e-11), name
        nearly = abs(decision.slack - relaxed_above) < AGREEMENT * scale
        assert status is decision.status or (nearly and {status, decision.status} <= {Status.MODIFIED, Status.RELAXED})


@requests_of(200, some=60)
@pytest.mark.parametrize("name", DESIGNS)
def test_random_requests_get_the_decisions_of_the_filter(name: str, count: int) -> None:
    core = SafetyPassivityFilter(DESIGNS[name])
    many = BatchFilter(core, count)
    asked = requests(DESIGNS[name], count, seed=17)
    many.decide(*asked)
    assert_same(many, one_by_one(core, asked))

    x, _, *others = asked  # the next tick: inputs do not jump any more
    for _ in range(2):
        asked = (x, many.part("u_plus")[:, : many.batch.used].copy(), *others)
        many.decide(*asked)
        assert_same(many, one_by_one(core, asked))
    answered = many.status < Status.UNCERTIFIED
    protected = answered & (many.part("lowest_psi")[0] >= 0)
    assert many.scalar[protected].mean() < 0.5


@requests_of(200, some=60)
@pytest.mark.parametrize("name", DESIGNS)
def test_every_decision_meets_the_certificate_or_is_the_filter_s(name: str, count: int) -> None:
    design = DESIGNS[name]
    many = BatchFilter(SafetyPassivityFilter(design), count)
    many.decide(*requests(design, count, seed=18))
    at_once = ~many.scalar
    primal, dual, gap = (many.part(name)[0, at_once] for name in ("primal", "dual", "gap"))

    assert max(primal.max(), dual.max()) <= design.tolerance.residual
    assert gap.max() <= design.tolerance.gap
    assert many.part("shortfall")[0, at_once].max() <= 0.0
    assert many.part("outside_trust_region")[0, at_once].max() <= 0.0
    assert (many.status[at_once] < Status.UNCERTIFIED).all()
    u_plus, u = many.part("u_plus")[:, at_once], many.part("u")[:, at_once]
    limits = design.limits
    assert (np.abs(u_plus) <= np.array(limits.magnitude)[:, None]).all()
    if limits.norm is not None:
        assert np.linalg.norm(u_plus, axis=0).max() <= limits.norm * (1 + 1e-12)
    if limits.rise_per_s is not None:
        assert (np.abs(u_plus - u) <= design.dt_s * np.array(limits.rise_per_s)[:, None] * (1 + 1e-12)).all()


@pytest.mark.parametrize(
    ("bound", "z", "lam", "accepted"),
    [
        (2.0, 2.0, 2.0, True),
        (2.0, 0.0, 0.0, False),  # misses the row
        (2.0, 4.0, 4.0, False),  # keeps it, but nothing pushes so far: a duality gap
        (-3.0, 0.0, -6.0, False),  # no gap, but a row that pulls
    ],
)
def test_a_guess_counts_only_with_all_of_the_certificate(bound: float, z: float, lam: float, accepted: bool) -> None:
    """One row u₁ ≥ bound at rest; whatever is guessed, the answer is the filter's."""
    many = BatchFilter(row_filter(hard=1, soft=False), 1)

    def guess(into_z: Array, into_lam: Array) -> None:
        into_z[:] = 0.0
        into_z[0], into_lam[0] = z, lam

    many._points.find = guess  # type: ignore[method-assign]  # what is guessed is the point
    zero = np.zeros((2, 1))
    many.decide(np.array([row_state([(1.0, 0.0, -bound)])]).T, zero, zero, zero)

    assert bool(many.scalar[0]) is not accepted
    assert many.part("u_plus")[:, 0] == pytest.approx([max(bound, 0.0), 0.0], abs=1e-6)


def test_first_inputs_are_the_filter_s() -> None:
    design = damped_design(input_rate_bound_per_s=100.0)
    core = SafetyPassivityFilter(design)
    many, asked = BatchFilter(core, 50), requests(design, 50, seed=19)
    many.decide(*asked, start=True)

    assert many.scalar.all()
    assert_same(many, one_by_one(core, asked, start=True))


def test_nothing_is_left_of_decisions_before() -> None:
    """The filter's own decisions have relaxed rows, tangents and multipliers; the next one has none of them."""
    design = damped_design(input_bound=20.0, input_norm_bound=12.0)
    core = SafetyPassivityFilter(design)
    many, quiet = BatchFilter(core, 64), requests(design, 64, seed=20)
    many.decide(*quiet)
    expected = many.batch.block.copy()
    many.decide(*quiet, scalar=True)
    assert many.scalar.all()
    many.decide(*requests(design, 64, seed=21))
    many.decide(*quiet)

    np.testing.assert_array_equal(many.batch.block, expected)
    many.decide(*quiet, scalar=True)
    assert_same(many, one_by_one(core, quiet))


@pytest.mark.parametrize("hostile", [nan, inf, -inf, 1e300, -1e300, 5e-324])
def test_hostile_elements_get_the_scalar_answer_alone(hostile: float) -> None:
    design = drag_design()
    core = SafetyPassivityFilter(design)
    asked = requests(design, 40, seed=22)
    many = BatchFilter(core, 40)
    many.decide(*asked)
    undisturbed = many.batch.block.copy()
    for element, argument in enumerate(asked):
        argument[..., element] = hostile
    many.decide(*asked)

    assert_same(many, one_by_one(core, asked))
    assert np.isfinite(many.part("u_plus")).all()
    np.testing.assert_array_equal(many.batch.block[:, len(asked) :], undisturbed[:, len(asked) :])
    if not abs(hostile) < inf:
        assert (many.status[: len(asked)] >= Status.UNCERTIFIED).all()


def test_meeting_conflicting_and_zero_gradient_rows() -> None:
    """Three rows of a filter that reads them from its state: every number of active rows, infeasible ones too."""
    core = row_filter(hard=2, soft=True, input_bound=5.0)
    rng = np.random.default_rng(23)
    states = []
    for _ in range(500):
        rows = [(*unit(rng.normal(size=2)) * 10 ** rng.uniform(-8, 1), rng.normal() * 4) for _ in range(3)]
        if rng.uniform() < 0.3:
            rows[1] = (*(-np.array(rows[0][:2])), rng.normal())
        states.append(row_state(rows))
    zero = np.zeros((2, len(states)))
    asked = (np.array(states).T, zero, zero, zero, np.zeros(len(states)), np.zeros(len(states)))
    many = BatchFilter(core, len(states))
    many.decide(*asked)
    expected = one_by_one(core, asked)

    assert_same(many, expected)
    at_once = [decision for decision, scalar in zip(expected, many.scalar.tolist(), strict=False) if not scalar]
    active = [int((decision.duals > 1e-3).sum()) for decision in at_once]
    assert {0, 1, 2} <= set(active)
    assert Status.INFEASIBLE in {decision.status for decision in expected}
    assert len(at_once) > len(states) / 4


def test_guess_binds_row_and_limit_where_both_are_active() -> None:
    """From (4.5, 0), (0.6, 0.8)ᵀu ≥ 6 leads beyond u₁ ≤ 5, to (5, 3.75) with it; the same to all sides."""
    core = row_filter(hard=1, soft=False, input_bound=5.0)
    sides = [np.diag(signs)[order] for signs in product((1.0, -1.0), repeat=2) for order in ([0, 1], [1, 0])]
    asked = np.array([side @ (4.5, 0.0) for side in sides]).T
    states = np.array([row_state([(*side @ (0.6, 0.8), -6.0)]) for side in sides]).T
    many = BatchFilter(core, len(sides))
    many.decide(states, asked, asked, np.zeros_like(asked))

    assert not many.scalar.any()
    np.testing.assert_allclose(many.part("u_plus").T, [side @ (5.0, 3.75) for side in sides], atol=1e-9)


def test_an_element_s_decision_does_not_depend_on_the_others() -> None:
    design = drag_design(input_bound=12.0)
    core = SafetyPassivityFilter(design)
    asked = requests(design, 60, seed=24)
    together = BatchFilter(core, 60)
    together.decide(*asked)
    alone = BatchFilter(core, 1)
    for element in range(0, 60, 7):
        alone.decide(*(each[..., element : element + 1] for each in asked))

        np.testing.assert_array_equal(alone.batch.block[:, 0], together.batch.block[:, element])
        assert alone.status[0] == together.status[element]


def test_gradients_and_numbers_of_rows_are_those_of_the_filter() -> None:
    design = damped_design()
    core = SafetyPassivityFilter(design)
    many, asked = BatchFilter(core, 5), requests(design, 5, seed=25)
    many.decide(*asked)
    for element, decision in enumerate(one_by_one(core, asked)):
        G = decision.part("G").reshape((2, 3), order="F")
        np.testing.assert_allclose(many.gradients[:, :, element].T, G[:, :2], atol=1e-12)
    assert (many.constraints, many.hard) == (2, 1)


def test_a_gatekeeper_judges_every_element() -> None:
    core = SafetyPassivityFilter(paper_design(mode=Mode.SAFE, gatekeeper=True))
    many = BatchFilter(core, 4)
    many.decide(np.full((4, 4), 2.0), np.zeros((2, 4)), np.zeros((2, 4)), 0.0)

    assert many.scalar.all()
