"""``decide`` answers whatever it is asked, the same each time."""

from itertools import product
from math import inf, isfinite, isnan, nan

import numpy as np
import pytest
from core_designs import PAPER_START, drag_design, jerk_design, paper_design, paper_passivity, pump_design, row_filter
from hypothesis import example, given, settings
from hypothesis import strategies as st
from random_requests import requests_of

from passafe.decision import Decision, Status
from passafe.design import Law, Mode
from passafe.errors import ShapeError
from passafe.filter import SafetyPassivityFilter
from passafe.tank import Tank

HOSTILE = (
    nan,
    inf,
    -inf,
    1e300,
    -1e300,
    1.7976931348623157e308,
    1e155,
    -1e150,
    5e-324,
    -5e-324,
    1e-308,
    0.0,
    -0.0,
    1e12,
)
FINITE = tuple(value for value in HOSTILE if isfinite(value))

Request = tuple[list[float], list[float], list[float], list[float], float]


def with_tank() -> SafetyPassivityFilter:
    plain = paper_design()
    return SafetyPassivityFilter(
        paper_design(
            system=plain.system,
            u_fb=plain.u_fb,
            fail_safe=plain.fail_safe,
            barriers=plain.barriers,
            passivity=paper_passivity(plain.system.x, tank=Tank()),
        )
    )


FILTERS = {
    "sampled": SafetyPassivityFilter(paper_design()),
    "tank": with_tank(),
    "continuous": SafetyPassivityFilter(paper_design(law=Law.CONTINUOUS)),
    "off": SafetyPassivityFilter(paper_design(mode=Mode.OFF)),
    "passive": SafetyPassivityFilter(paper_design(mode=Mode.PASSIVE)),
    "drag": SafetyPassivityFilter(drag_design()),
    "jerk, continuous": SafetyPassivityFilter(jerk_design(law=Law.CONTINUOUS)),
    "pump": SafetyPassivityFilter(pump_design()),
    "rows": row_filter(hard=2, soft=True),
}


def lengths(made: SafetyPassivityFilter) -> tuple[int, ...]:
    n, m = made.design.system.n, made.design.system.m
    return n, m, m, m, 1


def request(made: SafetyPassivityFilter, numbers: list[float]) -> Request:
    """Deal numbers out to the arguments of ``decide``."""
    supply = iter(numbers)
    x, u, u_h, u_h_rate, tank = ([next(supply) for _ in range(length)] for length in lengths(made))
    return x, u, u_h, u_h_rate, tank[0]


def assert_honest(made: SafetyPassivityFilter, asked: Request, decision: Decision) -> None:
    """Finite and bounded in any case; if it claims to be certified, then the evidence stands and is finite."""
    bound, tolerance = made.design.input_bound, made.design.tolerance
    assert len(decision.u) == made.design.system.m
    assert all(isfinite(value) and abs(value) <= bound for value in decision.u)
    assert decision.part("u_plus").tolist() == list(decision.u)
    if decision.status.is_fallback or decision.status is Status.BACKUP:  # the backup law's input, whatever the rows ask
        return
    assert all(isfinite(value) for part in asked[:4] for value in part)
    assert isfinite(asked[4])
    assert np.isfinite(decision.margins).all()
    assert np.isfinite(decision.psi).all() or made.design.mode in {Mode.OFF, Mode.PASSIVE}
    assert np.isfinite(decision.part("u_ref")).all()
    assert max(decision.primal_residual, decision.dual_residual) <= tolerance.residual
    assert decision.gap <= tolerance.gap
    assert decision.margins.min(initial=0.0) >= -1.01e-6 * (1 + np.linalg.norm(decision.part("z")))


def number() -> st.SearchStrategy[float]:
    return st.one_of(st.sampled_from(HOSTILE), st.floats(-10, 10), st.floats(allow_subnormal=True))


@pytest.mark.parametrize("name", FILTERS)
@settings(max_examples=40)  # the two tests below go through the hostile numbers one by one
@given(data=st.data())
def test_any_numbers_get_a_bounded_input_and_a_true_status(name: str, data: st.DataObject) -> None:
    made = FILTERS[name]
    count = sum(lengths(made))
    asked = request(made, data.draw(st.lists(number(), min_size=count, max_size=count)))

    assert_honest(made, asked, made.decide(*asked))


@pytest.mark.parametrize("name", FILTERS)
def test_one_hostile_number_in_any_place_among_ordinary_ones(name: str) -> None:
    made = FILTERS[name]
    rng = np.random.default_rng(60)
    for place, value in product(range(sum(lengths(made))), HOSTILE):
        numbers = rng.uniform(-2, 2, sum(lengths(made))).tolist()
        numbers[place] = value
        asked = request(made, numbers)
        decision = made.decide(*asked)

        assert_honest(made, asked, decision)
        if not isfinite(value):
            assert decision.status.is_fallback


@pytest.mark.parametrize("name", FILTERS)
def test_the_same_hostile_number_everywhere(name: str) -> None:
    made = FILTERS[name]
    for value in HOSTILE:
        asked = request(made, [value] * sum(lengths(made)))

        assert_honest(made, asked, made.decide(*asked))


@pytest.mark.parametrize("name", FILTERS)
def test_minus_zero_is_zero(name: str) -> None:
    made = FILTERS[name]
    plus, minus = (made.decide(*request(made, [zero] * sum(lengths(made)))) for zero in (0.0, -0.0))

    assert plus.status is minus.status
    assert plus.u == minus.u


@example(speed=1e300, spread=-1e300)
@given(speed=st.floats(allow_nan=False, allow_infinity=False), spread=st.floats(allow_nan=False, allow_infinity=False))
def test_the_fallback_is_the_fail_safe_within_the_bound(speed: float, spread: float) -> None:
    """U = −9 x₂ of the paper's robot, in each axis within ±100, where the other arguments make a QP impossible."""
    decision = FILTERS["sampled"].decide((nan, 0.0, speed, spread), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0))

    assert decision.status.is_fallback
    for value, held in zip((speed, spread), decision.u, strict=True):
        expected = -9.0 * value
        assert held == (0.0 if isnan(expected) else min(max(expected, -100.0), 100.0))


def test_nan_argument_names_no_solver() -> None:
    decision = FILTERS["off"].decide((nan, 0, 0, 0), (0, 0), (0, 0), (0, 0))

    assert (decision.status, decision.u) == (Status.UNCERTIFIED, (0.0, 0.0))


@pytest.mark.parametrize(
    "changed",
    [
        {0: 3},
        {0: 5},
        {1: 1},
        {2: 3},
        {3: 0},
        {0: 5, 1: 1},  # lengths that add up all the same
        {1: 1, 2: 3},
        {0: 2, 3: 4},
        {0: 0, 1: 0, 2: 10, 3: 0},
    ],
)
def test_wrong_lengths_are_refused(changed: dict[int, int]) -> None:
    sizes = [changed.get(i, size) for i, size in enumerate((4, 2, 2, 2))]
    x, u, u_h, u_h_rate = ([1.0] * size for size in sizes)

    with pytest.raises(ShapeError) as refused:
        FILTERS["sampled"].decide(x, u, u_h, u_h_rate)

    got = ", ".join(map(str, sizes))
    assert str(refused.value) == f"x, u, u_h, u_h_rate: got lengths {got}, allowed lengths 4, 2, 2, 2"


def test_any_sequence_of_numbers_will_do() -> None:
    made = FILTERS["sampled"]
    zero = (0.0, 0.0)
    of_tuples = made.decide(PAPER_START, zero, (-3.0, 0.0), zero)
    of_lists = made.decide(list(PAPER_START), [0.0, 0.0], [-3.0, 0.0], [0.0, 0.0])
    of_integers = made.decide([2, 2, -1, -1], [0, 0], [-3, 0], [0, 0])

    assert of_tuples.block.tobytes() == of_lists.block.tobytes() == of_integers.block.tobytes()


@requests_of(300, some=90)
@pytest.mark.parametrize("name", FILTERS)
def test_same_arguments_get_the_same_bits_in_any_order(name: str, count: int) -> None:
    made = FILTERS[name]
    rng = np.random.default_rng(61)
    asked = []
    for k in range(count):
        numbers = (rng.normal(size=sum(lengths(made))) * 10 ** rng.uniform(-3, 2)).tolist()
        if k % 3 == 0:
            numbers[rng.integers(len(numbers))] = HOSTILE[k // 3 % len(HOSTILE)]
        asked.append(request(made, numbers))

    def answers(order: list[int]) -> dict[int, tuple[bytes, Status, str, tuple[float, ...]]]:
        decisions = {k: made.decide(*asked[k]) for k in order}
        return {k: (d.block.tobytes(), d.status, d.solver, d.u) for k, d in decisions.items()}

    forwards = answers(list(range(len(asked))))

    assert len({status for _, status, *_ in forwards.values()}) >= 2
    assert answers(rng.permutation(len(asked)).tolist()) == forwards
    twin = SafetyPassivityFilter(made.design)
    assert all(twin.decide(*asked[k]).block.tobytes() == forwards[k][0] for k in range(0, len(asked), 7))


@pytest.mark.parametrize("name", FILTERS)
def test_no_bound_reaches_the_solver_that_it_would_remember(name: str) -> None:
    """PIQP takes d < −1e30 and NaN for absent rows, and goes on doing so: d stays above −2·reach, and is a number."""
    made = FILTERS[name]
    reach = 2 * made.design.input_bound * np.sqrt(made.design.system.m)
    rng = np.random.default_rng(62)
    for value in HOSTILE:
        numbers = rng.uniform(-2, 2, sum(lengths(made)))
        numbers[rng.uniform(size=numbers.size) < 0.3] = value

        assert (made.decide(*request(made, numbers.tolist())).part("d") >= -2 * reach).all()
