"""The core's functions over many samples, against closed forms and against fine integration."""

from typing import Any

import numpy as np
import pytest
from damped_point_run import DampedPoint, scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from scipy.integrate import solve_ivp

SAMPLES = 50
T_S = np.linspace(0.0, 5.0, SAMPLES)


@pytest.fixture
def samples() -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(1)
    return random.normal(size=(4, SAMPLES)), random.normal(scale=10, size=(2, SAMPLES))


def test_the_papers_robot_is_the_damped_point(samples: tuple[np.ndarray, np.ndarray]) -> None:
    core, closed = CoreEvaluator(scenario()), DampedPoint()
    x, u = samples
    assert core.h(x, T_S) == pytest.approx(closed.h(x, T_S), abs=1e-12)
    assert core.power_margin(x, u) == pytest.approx(closed.power_margin(x, u), abs=1e-10)
    for duration_s in (1e-4, 1e-3, 0.5):
        assert core.flow(x, u, duration_s) == pytest.approx(closed.flow(x, u, duration_s), abs=1e-12)


def test_barriers_come_in_the_scenarios_order(samples: tuple[np.ndarray, np.ndarray]) -> None:
    content: dict[str, Any] = scenario().model_dump()
    wall = {"kind": "half-plane", "name": "wall", "normal": (0, 1), "offset": -3}
    content["filter"]["barriers"] += (wall | {"class_k": content["filter"]["barriers"][0]["class_k"]},)
    x, _ = samples
    h = CoreEvaluator(Scenario.model_validate(content)).h(x, T_S)
    assert h.shape == (2, SAMPLES)
    assert h[0] == pytest.approx(DampedPoint().h(x, T_S)[0])
    assert h[1] == pytest.approx(x[1] + 3)


def test_without_barriers_there_is_nothing_to_keep(samples: tuple[np.ndarray, np.ndarray]) -> None:
    x, u = samples
    core = CoreEvaluator(scenario(barriers=[]))
    assert core.h(x, T_S).shape == (0, SAMPLES)
    assert core.power_margin(x, u).shape == (SAMPLES,)


def test_a_nonlinear_plant_flows_within_its_stated_accuracy(samples: tuple[np.ndarray, np.ndarray]) -> None:
    content: dict[str, Any] = scenario().model_dump()
    content["plant"] |= {"model": "drag-point", "parameters": {"sigma": 0.5, "drag": 0.5}}
    core = CoreEvaluator(Scenario.model_validate(content))
    x, u = samples
    reached = core.flow(x, u, 1e-3)
    for k in range(0, SAMPLES, 10):
        force = u[:, k]

        def rate(_t: float, z: np.ndarray, force: np.ndarray = force) -> np.ndarray:
            speed = np.linalg.norm(z[2:])
            return np.concatenate([z[2:], -(0.5 + 0.5 * speed) * z[2:] + force])

        truth = solve_ivp(rate, (0, 1e-3), x[:, k], rtol=1e-12, atol=1e-14).y[:, -1]
        assert reached[:, k] == pytest.approx(truth, abs=1e-10)


def test_protected_values_are_those_that_the_rows_assume(samples: tuple[np.ndarray, np.ndarray]) -> None:
    core, closed = CoreEvaluator(scenario()), DampedPoint()
    x, _ = samples
    assert [name.partition(" ")[0] for name in core.protected] == ["ψ0", "ψ1"]
    assert core.psi(x, T_S) == pytest.approx(closed.psi(x, T_S), abs=1e-9)
    assert CoreEvaluator(scenario(barriers=[])).protected == ()


def test_errors_of_h_are_tiny_and_grow_with_those_of_the_state(samples: tuple[np.ndarray, np.ndarray]) -> None:
    core = CoreEvaluator(scenario())
    x, u = samples
    exact, wrong = (core.h_error(x, T_S, np.full(SAMPLES, error)) for error in (0.0, 1e-6))
    assert (exact > 0).all()
    assert (exact < 1e-13).all()
    assert wrong - exact == pytest.approx(2e-6 * np.abs(x[:2]).sum(axis=0, keepdims=True), rel=1e-6)
    assert not core.flow_error(x, u, 1e-3).any()


def test_a_nonlinear_flow_has_an_error_within_the_plants(samples: tuple[np.ndarray, np.ndarray]) -> None:
    content: dict[str, Any] = scenario().model_dump()
    content["plant"] |= {"model": "drag-point", "parameters": {"sigma": 0.5, "drag": 0.5}}
    error = CoreEvaluator(Scenario.model_validate(content)).flow_error(*samples, 1e-3)
    assert error.shape == (SAMPLES,)
    assert (error > 0).all()
    assert (error <= 1e-10).all()
