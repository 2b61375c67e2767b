"""Rows that leave next to no room: what rests there stays there."""

from dataclasses import replace

import numpy as np
import pytest
from core_designs import paper_design

from passafe.barrier_chain import Barrier
from passafe.barriers import disk_keep_out
from passafe.decision import Status
from passafe.design import Mode
from passafe.filter import SafetyPassivityFilter
from passafe.sampled_plant import SampledPlant


@pytest.mark.parametrize("gap", [1e-4, 2e-6, 1e-8])
def test_a_robot_between_two_disks_that_nearly_touch_stays(gap: float) -> None:
    """At rest where both disks are half the gap away, and pushed from one to the other."""
    design = paper_design(mode=Mode.SAFE)
    position = design.system.x[:2]
    disks = tuple(
        Barrier(
            name=name, h=disk_keep_out(position, centre=(side * (0.7 + gap / 2), 0.0), radius=0.7), class_k=(8.0,) * 3
        )
        for name, side in (("left", -1), ("right", 1))
    )
    made = SafetyPassivityFilter(replace(design, barriers=disks, u_fb=0.0 * design.u_fb))
    plant = SampledPlant(design.system, design.passivity.V, design.dt_s)
    x, u = (0.0,) * 4, (0.0, 0.0)
    for k in range(400):
        decision = made.decide(x, u, (3.0 if (k // 50) % 2 else -3.0, 0.0), (0.0, 0.0))
        u = decision.u
        x = plant.advance(x, u).x
        assert decision.status is not Status.INFEASIBLE
        assert np.hypot(x[2], x[3]) < 0.1
        assert min(np.hypot(x[0] - side * (0.7 + gap / 2), x[1]) for side in (-1, 1)) >= 0.7 - 1e-12
