"""The fallback's choice among inputs, judged by the courses that they lead to."""

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from passafe.answers.replaced_answer import BETWEEN
from passafe.barrier_chain import Barrier, derive_chains
from passafe.class_k import Linear
from passafe.courses.backup_rollout import BackupRollout, least_of_cubic
from passafe.courses.course import KEPT, Course
from passafe.courses.fallback import Fallback, between
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant
from passafe.system import System

ZERO = (0.0,)


def coaster(**changes: object) -> FilterDesign:
    """Return v̇ = −v/3 + a with a lag of 6 ms, 30 Hz; to stay left of 1, no faster than 0.6; braking is coasting.

    From v it coasts 3v metres on. The rows at samples ask for far more than a period can take: 5 lags are over by then.
    """
    x, u = ca.SX.sym("x", 3), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(x[1], x[2] - x[1] / 3, (u - x[2]) / 0.006), y=x[1]),
        u_fb=ca.SX(0),
        fail_safe=ca.SX(0),
        barriers=(
            Barrier(name="wall", h=1 - x[0], class_k=(Linear(gain=27.0),) * 4),
            Barrier(name="speed", h=0.36 - x[1] ** 2, class_k=(Linear(gain=6.0),) * 3),
        ),
        passivity=Passivity(V=x[1] ** 2 / 2),
        k_i=1.0,
        dt_s=0.03,
        input_bound=50.0,
        mode=Mode.SAFE,
    )
    return replace(design, **changes)  # type: ignore[arg-type]  # by name


def fallback(design: FilterDesign) -> Fallback:
    return Fallback(design, [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)])


def test_a_part_of_the_way_brakes_where_all_of_it_races() -> None:
    """Towards the wall at 0.4 m/s, 0.2 m away: coasting hits it, full input backwards is past 0.6 m/s in a period."""
    x, before, full = np.array([0.8, 0.4, 0.0]), np.zeros(1), np.array([-50.0])
    judge = fallback(coaster())

    assert judge.best(x, 0.0, before, [full]).place is None
    parts = between(before, [full])
    place = judge.best(x, 0.0, before, [full, *parts]).place
    assert place is not None
    assert -50.0 < parts[place - 1][0] < 0.0


def strolling(drag: float, slower: float) -> SafetyPassivityFilter:
    """Return the filter of ẍ = u − drag·‖ẋ‖ẋ, to keep left of 4, or the slower the further it is to the right."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    speed, gain = ca.norm_2(x[2:]), Linear(gain=5.0)
    limit = Barrier(name="limit", h=1 - speed - slower * x[0], class_k=(gain,) * 2)
    wall = Barrier(name="wall", h=4 - x[0], class_k=(gain,) * 3)
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(x[2:], u - drag * speed * x[2:]), y=x[2:]),
        u_fb=ca.SX.zeros(2),
        fail_safe=-3 * x[2:],
        barriers=(limit,) if slower else (wall,),
        passivity=Passivity(V=ca.sumsqr(x[2:]) / 2),
        k_i=50.0,
        dt_s=1e-3,
        input_bound=10.0,
        mode=Mode.SAFE,
    )
    return SafetyPassivityFilter(design)


@pytest.mark.parametrize("v", [0.0, 1e-12, 1e-9, 1e-6, 1e-5])
@pytest.mark.parametrize(("drag", "slower"), [(1.0, 0.0), (0.0, 0.5)])
def test_what_cannot_be_bounded_does_not_keep_a_robot_standing(v: float, drag: float, slower: float) -> None:
    """Neither −‖v‖v nor ‖v‖ has a bounded curvature at rest, so no course that moves is proven; yet it starts."""
    decision = strolling(drag, slower).decide((0.0, 0.0, v, 0.0), (0.0, 0.0), (10.0, 0.0), (0.0, 0.0))

    assert decision.u[0] > 1e-3


def test_nothing_is_lost_where_a_part_of_the_way_brakes() -> None:
    design = coaster()
    made, plant = SafetyPassivityFilter(design), SampledPlant(design.system, design.passivity.V, design.dt_s)
    x: Sequence[float] = (0.8, 0.4, 0.0)
    u, solvers = ZERO, set()
    for _ in range(60):
        decision = made.decide(x, u, (50.0,), ZERO)
        u = decision.u
        solvers.add(decision.solver)
        x = plant.advance(x, u).x
        assert x[0] <= 1.0
        assert abs(x[1]) <= 0.6
    assert BETWEEN in solvers


@pytest.mark.parametrize(("hold_s", "expected"), [(0.01, 0), (0.3, None)])
def test_a_candidate_counts_by_its_worse_hold(hold_s: float, expected: int | None) -> None:
    """Backwards from 0.4 m/s at −4 m/s²: a period brakes a little, thirty end at 0.8 m/s."""
    judge = fallback(coaster(dt_s=0.01, hold_s=hold_s))

    assert judge.best(np.array([0.8, 0.4, 0.0]), 0.0, np.zeros(1), [np.array([-4.0])]).place == expected


def test_to_drive_away_from_a_wall_is_no_worse_than_to_rest() -> None:
    """5 cm beyond the wall and at rest: full input backwards is least below zero at once, as braking is for ever."""
    rest = np.array([1.05, 0.0, 0.0])

    assert fallback(coaster()).best(rest, 0.0, np.zeros(1), [np.array([-5.0])]).place == 0


def test_a_course_that_is_already_worse_is_not_followed() -> None:
    design = coaster()
    chains = [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)]
    rollout, state = BackupRollout(design, chains), (np.array([0.8, 0.4, 0.0]), 0.0, np.zeros(1), 0)
    whole, part = rollout.course(*state), rollout.course(*state, KEPT)

    assert whole.comes_to_rest
    assert not part.comes_to_rest
    assert part.kept_periods == whole.kept_periods
    assert whole.lowest <= part.lowest < 0
    assert not part.is_no_worse_than(KEPT)


def test_the_worse_of_two_courses_has_the_worst_of_each() -> None:
    other = Course(
        kept_periods=3.0, lowest=-0.5, proven=-0.5, soon=-0.5, lowest_at=7, is_proven=False, comes_to_rest=True
    )

    assert KEPT.or_worse(other) == other.or_worse(KEPT) == other


@pytest.mark.parametrize(
    ("begin", "end", "slopes", "expected"),
    [
        (0.0, 0.0, (-1.0, 1.0), -0.25),  # s² − s
        (0.0, 0.0, (-1.0, 2.0), -2 / (3 * 3**0.5)),  # s³ − s
        (0.0, 0.0, (-1.0, -1.0), -(3**0.5) / 18),  # −2s³ + 3s² − s
        (0.0, 1.0, (1.0, 1.0), 0.0),  # s
        (1.0, 0.0, (-1.0, -1.0), 0.0),  # 1 − s
        (0.0, -1.0, (1.0, -3.0), -1.0),  # s − 2s²
        (0.0, 0.0, (0.0, 0.0), 0.0),
    ],
)
def test_a_cubic_is_least_at_an_end_or_in_between(
    begin: float, end: float, slopes: tuple[float, float], expected: float
) -> None:
    assert float(least_of_cubic(ca.SX(begin), ca.SX(end), *map(ca.SX, slopes))) == pytest.approx(expected, abs=1e-12)


def test_a_loss_between_samples_counts_without_a_bound() -> None:
    """A pendulum with ωT = 2 swings to −0.3 and back within a period: too far for the tube, past the wall at −0.25."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    design = coaster(
        system=System(x=x, u=u, f=ca.vertcat(x[1], u - 400 * ca.sin(x[0])), y=x[1]),
        barriers=(Barrier(name="wall", h=x[0] + 0.25, class_k=(Linear(gain=1.0),) * 3),),
        passivity=Passivity(V=x[1] ** 2 / 2),
        dt_s=0.1,
    )
    chains = [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)]
    start = np.array([-0.3 * np.cos(1.0), -0.3 * 20 * np.sin(1.0)])

    course = BackupRollout(design, chains).course(start, 0.0, np.zeros(1), 0)

    assert not course.is_proven
    assert course.kept_periods == 0
    after = SampledPlant(design.system, design.passivity.V, design.dt_s).advance(start, ZERO)
    assert min(start[0], after.x[0]) > -0.2, "at the samples nothing is lost"


def test_a_course_that_blows_up_keeps_nothing() -> None:
    """From x = 2, ẋ = x³ is infinite after 1/8 s; the law does nothing about it."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    design = coaster(
        system=System(x=x, u=u, f=x**3 + u, y=x),
        barriers=(Barrier(name="wall", h=10 - x, class_k=(Linear(gain=1.0),) * 2),),
        passivity=Passivity(V=x**2 / 2),
        dt_s=0.1,
    )
    chains = [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)]
    course = BackupRollout(design, chains).course(np.array([2.0]), 0.0, np.zeros(1), 0)

    assert course.lowest == -np.inf
    assert course.kept_periods < 3
    assert not course.is_proven
    assert not course.comes_to_rest
