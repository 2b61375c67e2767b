"""The key ``filter.gatekeeper``: from the file to a wall that rows alone lose."""

from passafe_protocol.messages import FilterTick, PlantState
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of


def late_braking(**filter_keys: object) -> Scenario:
    """Return a push to a wall at x₁ = 0 with gains of 20/s, which |u| ≤ 2 cannot brake as late as they allow."""
    gains = [{"kind": "linear", "gain": 20.0}] * 3
    wall = {"kind": "half-plane", "name": "wall", "normal": [-1.0, 0.0], "offset": 0.0, "class_k": gains}
    return scenario_from(
        {
            "schema_version": 1,
            "name": "late-braking",
            "title": "a wall that asks for more braking than there is",
            "duration_s": 6.0,
            "rate_hz": 100.0,
            "plant": {"model": "damped-point", "x0": [-4.0, 0.0, 0.0, 0.0]},
            "operator": {"source": {"kind": "constant", "value": [2.0, 0.0]}},
            "filter": {
                "mode": "safe",
                "input_bound": 2.0,
                "k_i": 60.0,
                "feedback": {"k_p": 0.0, "k_d": 0.0},
                "barriers": [wall],
                **filter_keys,
            },
        },
        "late.toml",
    )


def driven(scenario: Scenario) -> tuple[float, float, set[str]]:
    """Return the furthest position, the largest speed towards the wall, and the statuses of all ticks."""
    states, statuses = [], set()

    def take(_topic: object, _header: object, body: object) -> None:
        if isinstance(body, PlantState):
            states.append(body.x)
        elif isinstance(body, FilterTick):
            statuses.add(body.status.name)

    loop = lockstep_loop(scenario, take)
    loop.run(steps_of(scenario))
    loop.finish()
    return max(x[0] for x in states), max(x[2] for x in states), statuses


def test_gatekeeper_is_off_unless_asked_for() -> None:
    scenario = load_scenario("tight-limits")

    assert not design_of(scenario, robot_of(scenario)).gatekeeper


def test_rows_alone_lose_the_wall() -> None:
    furthest, _, statuses = driven(late_braking())

    assert furthest > 0.3
    assert "INFEASIBLE" in statuses


def test_gatekeeper_of_a_file_keeps_the_wall() -> None:
    furthest, fastest, statuses = driven(late_braking(gatekeeper=True))

    assert furthest <= 0.0
    assert fastest > 1.5  # it was driven, not kept at rest
    assert "BACKUP" in statuses
