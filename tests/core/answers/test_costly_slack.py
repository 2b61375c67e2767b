"""Slack that grows with the input: a row that cannot be kept must not send the robot away at its limits."""

import numpy as np
import pytest

from passafe import (
    FilterDesign,
    Passivity,
    SafetyPassivityFilter,
    SampledPlant,
    Uncertainty,
    damped_point,
    kinetic_energy,
)

DT_S, LIMIT = 0.004, 40.0
ASKED = (10.0, 3.0)


@pytest.mark.parametrize(
    "sets",
    [
        Uncertainty(parameters={"mass": (0.8, 1.2)}),
        Uncertainty(parameters={"mass": (0.8, 1.2)}, state_error=(1e-3, 1e-3, 1e-2, 1e-2)),
        Uncertainty(disturbance=(0.0, 0.0, 0.2, 0.2), state_error=(0.0, 0.0, 1e-2, 1e-2)),
    ],
)
def test_unknown_energy_leads_to_no_larger_input(sets: Uncertainty) -> None:
    robot = damped_point(sigma=1.0, mass=1.0)
    V = kinetic_energy(robot.velocity)
    design = FilterDesign(
        system=robot.system,
        fail_safe=robot.fail_safe,
        barriers=(),
        passivity=Passivity(V=V),
        k_i=80.0,
        dt_s=DT_S,
        input_bound=LIMIT,
        uncertainty=sets,
    )
    core, plant = SafetyPassivityFilter(design), SampledPlant(robot.system, V, DT_S)
    sample, u, largest, slacks = plant.at((0.0,) * 4), (0.0, 0.0), 0.0, []
    for k in range(60):
        decision = core.decide(sample.x, u, ASKED, (0.0, 0.0), start=k == 0)
        u = tuple(decision.u)
        largest = max(largest, float(np.abs(u).max()))
        slacks.append(decision.slack)
        sample = plant.advance(sample.x, u)

    assert largest <= 1.01 * max(ASKED)
    assert np.mean(slacks) < 0.2
