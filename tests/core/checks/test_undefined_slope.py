"""Parts whose slopes are no numbers at the start are named exactly where no decision is certified there."""

import casadi as ca
import pytest

from passafe.barrier_chain import Barrier
from passafe.checks.design_check import formula_findings
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Severity
from passafe.passivity import Passivity
from passafe.system import System

x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
p, v = x[:2], x[2:]
REST, NEAR = (0.0,) * 4, (1e-3, 1e-3, 1e-3, 1e-3)


def design_of(part: str, expression: ca.SX, mode: Mode) -> FilterDesign:
    parts = {"feedback u_fb": -v, "storage V": ca.sumsqr(v) / 2, "barrier 'wall' h": 4 - x[0]} | {part: expression}
    return FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(v, u), y=v),
        u_fb=parts["feedback u_fb"],
        barriers=(Barrier(name="wall", h=parts["barrier 'wall' h"], class_k=(5.0, 5.0, 5.0)),),
        passivity=Passivity(V=parts["storage V"]),
        k_i=1.0,
        dt_s=0.01,
        input_bound=5.0,
        mode=mode,
        fail_safe=-5 * v,
    )


@pytest.mark.parametrize(
    ("part", "expression", "mode"),
    [
        ("feedback u_fb", -ca.norm_2(v) * v, Mode.SAFE),
        ("feedback u_fb", -v / ca.norm_2(v), Mode.BOTH),
        ("feedback u_fb", -ca.sqrt(ca.fabs(v)), Mode.SAFE),
        ("storage V", ca.norm_2(v), Mode.BOTH),
        ("barrier 'wall' h", 1 - (x[0] ** 4 + x[1] ** 4) ** 0.25, Mode.SAFE),
    ],
)
def test_a_slope_that_is_no_number_is_named(part: str, expression: ca.SX, mode: Mode) -> None:
    design = design_of(part, expression, mode)
    core = SafetyPassivityFilter(design)
    for x0, is_undefined in ((REST, True), (NEAR, False)):
        decision = core.decide(x0, (0.0, 0.0), (1.0, 0.0), (0.0, 0.0))
        found = [each for each in formula_findings(design, core.chains, x0) if each.topic == "slope"]

        assert (decision.status is Status.UNCERTIFIED) is is_undefined
        assert [each.subject for each in found] == [part] * is_undefined
        assert all(each.severity is Severity.WARNING for each in found)


@pytest.mark.parametrize("mode", Mode)
def test_slopes_that_are_numbers_are_not_mentioned(mode: Mode) -> None:
    design = design_of("storage V", ca.norm_2(v) if mode is Mode.SAFE else ca.sumsqr(v) / 2, mode)

    assert "slope" not in {each.topic for each in formula_findings(design, SafetyPassivityFilter(design).chains, REST)}
