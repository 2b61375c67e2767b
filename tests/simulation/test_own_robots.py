"""Loops of robots that a user's function returns, of kinds that no shipped robot is."""

from collections import Counter

import pytest
from own_robots import on_three_cables, scenario_of, two_tanks
from passafe_protocol.messages import FilterTick, PlantState
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of

from passafe.errors import NotAllowedError

VELOCITIES = {
    "kind": "coordinate-limits",
    "name": "limits",
    "of": "velocity",
    "low": [-1.0, -1.0],
    "high": [1.0, 1.0],
    "class_k": [{"kind": "linear", "gain": 4.0}] * 3,
}


def driven(scenario: Scenario) -> tuple[list[PlantState], Counter[str]]:
    """Return the states and the statuses of a scenario's loop."""
    states: list[PlantState] = []
    statuses: Counter[str] = Counter()

    def take(_topic: object, _header: object, body: object) -> None:
        if isinstance(body, PlantState):
            states.append(body)
        elif isinstance(body, FilterTick):
            statuses[body.status.name] += 1

    loop = lockstep_loop(scenario, take)
    loop.run(steps_of(scenario))
    loop.finish()
    return states, statuses


def test_robot_with_fewer_outputs_than_inputs_drives() -> None:
    states, statuses = driven(scenario_of(on_three_cables(), [0.0] * 4, [2.0, 0.5, 0.5], input_low=0.0))

    assert (len(states[-1].y), len(states[-1].u)) == (2, 3)
    assert 0.1 < states[-1].x[0] < 0.2
    assert set(statuses) == {"PASSED", "MODIFIED"}


def test_robot_without_a_velocity_drives() -> None:
    states, statuses = driven(scenario_of(two_tanks(), [1.0, 1.0], [2.0, 0.0], degree=1, input_low=0.0, input_high=2.0))

    assert 1.45 < states[-1].x[0] < 1.5
    assert set(statuses) == {"PASSED", "MODIFIED"}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"passivity": {"storage": "kinetic"}}, "storage: got kinetic, allowed squared-norm, or own"),
        ({"feedback": {"k_d": 1.0}}, "feedback.k_d: got 1, allowed 0: the robot has no velocity"),
        ({"barriers": [VELOCITIES]}, "velocity coordinate 1, allowed a robot with a velocity"),
    ],
)
def test_what_takes_a_velocity_is_refused_without_one(keys: dict[str, object], words: str) -> None:
    with pytest.raises(NotAllowedError, match=words):
        driven(scenario_of(two_tanks(), [1.0, 1.0], [2.0, 0.0], degree=1, **keys))
