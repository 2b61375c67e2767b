"""Closed loops under limits that are neither symmetric nor boxes: limits and barriers are kept all along."""

import numpy as np
import pytest
from core_designs import gains
from limit_sets import LIMIT_SETS

from passafe.barrier_chain import Barrier
from passafe.decision import Status
from passafe.design import FilterDesign
from passafe.filter import SafetyPassivityFilter
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity
from passafe.sampled_plant import SampledPlant
from passafe.storage import kinetic_energy

ANSWERS = {Status.PASSED, Status.MODIFIED, Status.RELAXED}
BRAKES = ("thrust that only pushes", "a polytope", "norms of parts", "everything")
"""Sets with inputs to every side of rest, or enough damping: from rest a wall can be kept."""


@pytest.mark.parametrize("name", LIMIT_SETS)
@pytest.mark.parametrize("push", [(30.0, 0.0), (-30.0, 20.0), (5.0, -40.0)])
def test_limits_are_kept_all_along(name: str, push: tuple[float, float]) -> None:
    robot = damped_point(sigma=4.0, gamma_1=2.0)
    wall = Barrier(name="wall", h=1 - robot.position[0], class_k=gains(2.0, 2.0, 2.0))
    design = FilterDesign(
        system=robot.system,
        fail_safe=robot.fail_safe,
        barriers=(wall,),
        passivity=Passivity(V=kinetic_energy(robot.velocity)),
        k_i=80.0,
        dt_s=2e-3,
        **LIMIT_SETS[name],  # type: ignore[arg-type]  # parts of many types by name
    )
    made, plant = SafetyPassivityFilter(design), SampledPlant(robot.system, design.passivity.V, design.dt_s)
    x, u, lowest, statuses = (0.0, 0.0, 0.0, 0.0), design.limits.centre, 1.0, set()
    for k in range(600):
        decision = made.decide(x, u, push, (0.0, 0.0), start=k == 0)
        before = None if k == 0 else np.array(u)
        assert design.limits.excess(np.array(decision.u), before, design.dt_s) <= 1e-11
        statuses.add(decision.status)
        x, u = plant.advance(x, decision.u).x, decision.u
        lowest = min(lowest, 1 - x[0])

    if name in BRAKES:
        assert statuses <= ANSWERS
    if statuses <= ANSWERS:
        assert lowest >= 0
    if push[0] > 10.0:
        assert lowest < 0.6
