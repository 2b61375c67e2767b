from collections.abc import Sequence

import numpy as np
import pytest
from core_designs import PAPER_START, paper_design

from passafe.decision import Status
from passafe.decision_schema import Assessment
from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array

START = (PAPER_START, (0.0, 0.0), (-3.0, 0.0), (0.0, 0.0))


@pytest.mark.parametrize("status", Status)
def test_fallbacks_are_those_that_may_miss_a_hard_row(status: Status) -> None:
    assert status.is_fallback == (status in {Status.UNCERTIFIED, Status.INFEASIBLE, Status.AT_SAMPLES})


def test_laws_that_replace_the_answer_have_no_certificate() -> None:
    assert {status for status in Status if not status.is_certified} == {
        Status.UNCERTIFIED,
        Status.AT_SAMPLES,
        Status.BACKUP,
    }


def test_properties_are_the_parts_of_the_block() -> None:
    decision = SafetyPassivityFilter(paper_design()).decide(*START)

    properties: dict[str, Sequence[float] | Array] = {
        "v": decision.v,
        "phi": decision.phi,
        "u_nominal": decision.u_nominal,
        "psi": decision.psi,
        "margins": decision.margins,
        "lam": decision.duals,
        "h_u": [decision.power_margin],
        "slack": [decision.slack],
        "primal": [decision.primal_residual],
        "dual": [decision.dual_residual],
        "gap": [decision.gap],
        "u_plus": decision.u,
    }
    for name, of_property in properties.items():
        assert list(of_property) == list(decision.part(name)) == list(decision.block[decision.layout.parts[name]]), name
    assert list(decision.part("x")) == list(PAPER_START)
    assert list(decision.part("u_h")) == [-3.0, 0.0]


def test_parts_cover_the_block_in_order_without_gaps() -> None:
    decision = SafetyPassivityFilter(paper_design()).decide(*START)
    edges = [(part.start, part.stop) for part in decision.layout.parts.values()]

    assert [start for start, _ in edges] == [0, *(stop for _, stop in edges[:-1])]
    assert edges[-1][1] == decision.block.size


def test_a_decision_keeps_its_numbers_when_others_are_made() -> None:
    paper = SafetyPassivityFilter(paper_design())
    decision = paper.decide(*START)
    before = decision.block.copy()
    paper.decide((9.0, 9.0, 9.0, 9.0), (1.0, 1.0), (1.0, 1.0), (1.0, 1.0))

    assert np.array_equal(decision.block, before)


def test_a_decision_cannot_be_rewritten() -> None:
    decision = SafetyPassivityFilter(paper_design()).decide(*START)

    with pytest.raises(AttributeError):
        decision.u = (0.0, 0.0)  # type: ignore[misc]  # that it is refused is the point


def test_stages_of_a_decision_are_views_of_its_block() -> None:
    decision = SafetyPassivityFilter(paper_design()).decide(*START)
    stages = (decision.request, decision.program, decision.answer, decision.evaluation)

    for name, view in ((name, view) for stage in stages for name, view in stage.fields().items()):
        assert np.shares_memory(view, decision.block) or not view.size
        assert view.ravel(order="F").tolist() == decision.part(name).tolist()
    assert decision.program.G.shape == (2, 3)
    assert decision.assessment.fields() == {name: decision.part(name)[0] for name in Assessment.names()}
