"""Distances of many decisions at once beside the distance of each."""

import numpy as np
import pytest
from core_designs import DESIGNS, Builder, paper_design, random_state

from passafe.admissible_shapes import HalfSpace
from passafe.decision import Decision
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.infeasibility import DistanceToInfeasibility
from passafe.row_distances import RowDistances

COUNT = 200


def share_decided(design: FilterDesign) -> float:
    """Return the share of random decisions that is decided together, all of them to the last bit as one by one."""
    core = SafetyPassivityFilter(design)
    rng, system, hard = np.random.default_rng(5), core.design.system, core.derivation.rows.hard
    decisions: list[Decision] = []
    for _ in range(COUNT):
        u_h = random_state(rng, system.m, 9.0)
        decisions.append(core.decide(random_state(rng, system.n), random_state(rng, system.m), u_h, u_h, 0.7))
    solver = DistanceToInfeasibility(design.limits, hard)

    found, decided = RowDistances(design.limits, hard, core.layout).of(np.stack([each.block for each in decisions]))

    one_by_one = np.array([solver.of(each).lower for each in decisions])
    assert found[decided].tobytes() == one_by_one[decided].tobytes()
    return float(decided.mean())


@pytest.mark.parametrize("builder", DESIGNS)
def test_each_is_that_of_its_decision_to_the_last_bit(builder: Builder) -> None:
    assert share_decided(builder(input_bound=20.0)) > 0.05  # of random states, far from where a robot drives


def test_a_norm_that_may_be_touched_leaves_it_open() -> None:
    wide, narrow = (share_decided(paper_design(input_bound=20.0, input_norm_bound=bound)) for bound in (30.0, 25.0))
    assert narrow < wide


def test_without_hard_rows_each_is_the_reach() -> None:
    assert share_decided(paper_design(mode=Mode.PASSIVE)) == 1.0


def test_half_spaces_are_left_to_the_solver() -> None:
    half_space = HalfSpace(weights=(0.6, 0.8), bound=5.0)
    assert share_decided(paper_design(input_half_spaces=(half_space,))) == 0.0
