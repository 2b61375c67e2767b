"""The fail-safe in the closed loop at low rates: inputs stop, the robot brakes and stands, and nothing is crossed."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from passafe_protocol.messages import PlantPhase, PlantState
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of

REST = {"damped-point": 4, "drag-point": 4, "saturating-point": 4, "lagged-point": 6}


def states_after_outage(model: str, parameters: dict[str, float], rate_hz: float, gain: float) -> list[PlantState]:
    """Return the plant states while it is driven at a wall at x = 1 and gets no input from 0.8 s on."""
    steep = {"kind": "linear", "gain": gain}
    n = REST[model]
    wall = {
        "kind": "half-plane",
        "name": "wall",
        "normal": [-1.0, 0.0],
        "offset": -1.0,
        "class_k": [steep] * (n // 2 + 1),
    }
    overrides: dict[str, Any] = {
        "plant.model": model,
        "plant.parameters": parameters,
        "plant.x0": [0.0] * n,
        "plant.hold_s": 0.0,
        "operator.source": {"kind": "constant", "value": [6.0, 0.0]},
        "filter.k_i": min(50.0, 0.6 * rate_hz),
        "filter.feedback": {"k_d": 1.0},
        "filter.passivity": {"kind": "tank", "storage": "kinetic"},
        "filter.barriers": [wall],
        "links": {"filter-to-plant": {"outages_s": [[0.8, 20.0]]}},
        "rate_hz": rate_hz,
        "duration_s": 6.0,
    }
    scenario = load_scenario("walls-and-disks", overrides)
    states: list[PlantState] = []
    loop = lockstep_loop(scenario, lambda _, __, body: states.append(body) if isinstance(body, PlantState) else None)
    loop.run(steps_of(scenario))
    return states


@pytest.mark.parametrize(
    ("model", "parameters"),
    [
        ("damped-point", {"sigma": 1.0}),
        ("damped-point", {"sigma": 0.05}),
        ("drag-point", {"sigma": 0.3, "drag": 2.0}),
        ("saturating-point", {"sigma": 1.0, "force": 60.0}),
        ("lagged-point", {"sigma": 1.0, "lag_s": 0.3}),
    ],
)
@pytest.mark.parametrize(("rate_hz", "gain"), [(10.0, 4.0), (20.0, 8.0), (100.0, 8.0)])
def test_it_brakes_and_stands(model: str, parameters: dict[str, float], rate_hz: float, gain: float) -> None:
    states = states_after_outage(model, parameters, rate_hz, gain)
    x = np.array([state.x for state in states])

    assert states[-1].phase is PlantPhase.FAIL_SAFE
    assert x[:, 0].max() <= 1.0
    assert np.abs(x[-1, 2:]).max() < 1e-3
    assert np.abs(x[:, 2]).max() > 0.1  # it was driven


def test_gains_beyond_those_that_are_kept_still_stand() -> None:
    states = states_after_outage("damped-point", {"sigma": 1.0}, 10.0, 24.0)
    x = np.array([state.x for state in states])
    stopping = [after for before, after in pairwise(states) if before.phase is PlantPhase.FAIL_SAFE]

    assert max(abs(state.x[2]) for state in stopping) < 1e-9  # one period is enough
    assert np.abs(x[-1, 2:]).max() < 1e-9
    assert x[:, 0].max() <= 1.0
