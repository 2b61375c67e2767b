"""Loops of robots, rates and gains that no shipped scenario has: driven at the limit, safe, and never sent away."""

from collections import Counter

import pytest
from passafe_protocol.messages import FilterTick, PlantState
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of

GAIN_4 = [{"kind": "linear", "gain": 4.0}] * 4
FALLBACKS = {"AT_SAMPLES", "UNCERTIFIED", "INFEASIBLE"}


class Drive:
    """States and statuses of one loop."""

    def __init__(self, scenario: Scenario) -> None:
        self.states: list[tuple[float, ...]] = []
        self.tank_j: list[float] = []
        self.h: list[float] = []
        self.statuses: Counter[str] = Counter()
        loop = lockstep_loop(scenario, self._take)
        loop.run(steps_of(scenario))
        loop.finish()

    def _take(self, _topic: object, _header: object, body: object) -> None:
        if isinstance(body, PlantState):
            self.states.append(body.x)
        elif isinstance(body, FilterTick):
            self.statuses[body.status.name] += 1
            self.h.append(min(barrier.psi[0] for barrier in body.barriers))
            self.tank_j.append(body.tank_j)


def pushed(
    model: dict[str, object], barrier: dict[str, object], *, push: float = 5.0, **filter_keys: object
) -> Scenario:
    """Return a scenario in which an operator pushes along the first axis, from rest at the origin, for 5 s."""
    return scenario_from(
        {
            "schema_version": 1,
            "name": "pushed",
            "title": "pushed along the first axis",
            "duration_s": 5.0,
            "rate_hz": 400.0,
            "plant": model,
            "operator": {"source": {"kind": "constant", "value": [push, 0.0]}},
            "filter": {
                "mode": "safe",
                "k_i": 40.0,
                "input_bound": 25.0,
                "feedback": {"k_d": 1.0},
                "passivity": {"kind": "power", "storage": "kinetic"},
                "barriers": [barrier],
                **filter_keys,
            },
        },
        "pushed.toml",
    )


def wall(gains: list[dict[str, object]]) -> dict[str, object]:
    return {"kind": "half-plane", "name": "wall", "normal": [-1.0, 0.0], "offset": -1.2, "class_k": gains}


@pytest.mark.parametrize("lag_s", [0.006, 0.015, 0.08])
def test_a_lagged_robot_goes_to_the_wall_and_rests(lag_s: float) -> None:
    model = {"model": "lagged-point", "parameters": {"lag_s": lag_s}, "x0": [0.0] * 6}
    drive = Drive(pushed(model, wall(GAIN_4)))

    assert not FALLBACKS & set(drive.statuses)
    assert min(drive.h) >= 0
    assert 1.15 <= drive.states[-1][0] <= 1.2
    assert abs(drive.states[-1][2]) < 0.05


def test_a_lagged_robot_drives_up_to_its_speed_limit() -> None:
    model = {"model": "lagged-point", "parameters": {"lag_s": 0.03}, "x0": [0.0] * 6}
    limit = {"kind": "speed-limit", "name": "speed", "limit_m_per_s": 1.5, "class_k": GAIN_4[:3]}
    drive = Drive(pushed(model, limit))
    fastest = max(x[2] for x in drive.states)

    assert not FALLBACKS & set(drive.statuses)
    assert 1.4 < fastest <= 1.5


def test_a_saturated_drive_is_never_called_infeasible() -> None:
    """Commands of 70 where the drive gives no more than 15."""
    model = {"model": "saturating-point", "parameters": {"force": 15.0}, "x0": [0.0] * 4}
    drive = Drive(pushed(model, wall(GAIN_4[:3]), push=70.0, input_bound=90.0))

    assert not FALLBACKS & set(drive.statuses)
    assert min(drive.h) >= 0
    assert drive.states[-1][0] > 1.1


@pytest.mark.parametrize("hold_s", [0.12, 0.18])
def test_long_holds_leave_no_wall(hold_s: float) -> None:
    """Inputs sent where margins for the hold leave none brake no worse than the fail-safe."""
    drive = Drive(load_scenario("walls-and-disks", {"plant.hold_s": hold_s, "rate_hz": 250.0, "duration_s": 6.0}))

    assert min(drive.h) >= 0


@pytest.mark.parametrize("rate_hz", [12.0, 25.0])
def test_a_slow_loop_sends_no_robot_away(rate_hz: float) -> None:
    drive = Drive(load_scenario("lagged-point", {"rate_hz": rate_hz, "filter.k_i": 4.0, "plant.hold_s": 1 / rate_hz}))

    assert min(drive.h) >= 0
    assert max(abs(value) for x in drive.states for value in x[:2]) < 5


def test_a_heavily_damped_robot_drives() -> None:
    drive = Drive(load_scenario("notomista-cai-2020", {"plant.parameters.sigma": 130.0}))

    assert not FALLBACKS & set(drive.statuses)
    assert min(drive.h) >= 0
    assert drive.states[-1][0] < 1.5  # from 2


@pytest.mark.parametrize("rate_hz", [300.0, 800.0])
def test_oscillating_commands_drain_no_tank(rate_hz: float) -> None:
    """A sine of 80 at a fifth of the tick rate: what a period takes between its samples is on the account."""
    source = {"kind": "sine", "amplitude": [80.0, 80.0], "frequency_hz": rate_hz / 5, "phase_rad": [0.0, 1.57]}
    tank = {"kind": "tank", "storage": "squared-norm", "slack_weight": 1e4}
    changes = {"operator.source": source, "filter.passivity": tank, "rate_hz": rate_hz, "duration_s": 4.0}
    drive = Drive(load_scenario("walls-and-disks", changes))

    assert min(drive.tank_j) >= 0
    assert min(drive.h) >= 0
    assert not FALLBACKS & set(drive.statuses)
