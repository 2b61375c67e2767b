"""The status does not depend on the input before, though margins and so inputs may."""

import casadi as ca

from passafe.barrier_chain import Barrier
from passafe.class_k import Linear
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.system import System

DISKS = ((0.6, -0.63, 0.35), (2.41, 1.21, 0.33))


def test_status_is_the_same_for_all_inputs_before() -> None:
    """Fast past a disk in a corner of the room, with full command down: rows can be kept, whatever was sent before."""
    x, u = ca.SX.sym("x", 4), ca.SX.sym("u", 2)
    p, v = x[:2], x[2:]
    heights = [3 - p[0], 3 + p[0], 2 - p[1], 2 + p[1]]
    heights += [(p[0] - a) ** 2 + (p[1] - b) ** 2 - r**2 for a, b, r in DISKS]
    gains = (Linear(gain=4.1), Linear(gain=3.4), Linear(gain=3.4))
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(v, u - 1.3 * v), y=v),
        u_fb=ca.SX.zeros(2),
        fail_safe=-20 * v,
        barriers=tuple(Barrier(name=f"h{k}", h=h, class_k=gains) for k, h in enumerate(heights)),
        passivity=Passivity(V=ca.sumsqr(v) / 2),
        k_i=1.0,
        dt_s=1e-3,
        hold_s=0.02,
        input_bound=300.0,
        mode=Mode.SAFE,
    )
    made = SafetyPassivityFilter(design)
    state = (2.95, 1.22, 0.15, 0.13)
    answers = [
        made.decide(state, before, (0.0, -100.0), (0.0, 0.0), start=True)
        for before in ((-6.1, -27.3), (0.0, 0.0), (200.0, -250.0))
    ]

    assert {answer.status for answer in answers} == {Status.MODIFIED}
