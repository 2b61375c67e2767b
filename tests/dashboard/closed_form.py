"""A run in closed form for the dashboard's tests: a robot that circles the disk of the paper's scenario.

p(t) = r(t)·(cos t, sin t) with r(t) = 1.5 + 0.3·cos 2t, so h(t) = r(t)² − 1; power margin 0.5 + 0.4·cos t.
"""

import tomllib
from math import cos, sin
from pathlib import Path
from typing import Any

from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    Consumed,
    Event,
    FilterStatus,
    FilterTick,
    Header,
    Health,
    LinkEvent,
    Message,
    OverrideReport,
    PlantPhase,
    PlantState,
    RowReport,
    ScenarioInfo,
    TopicHealth,
)
from passafe_services.scenarios.schema import Scenario

MS = 1_000_000
SCENARIOS = Path(__file__).parents[2] / "services" / "passafe_services" / "scenarios"


def paper_scenario() -> Scenario:
    return Scenario.model_validate(tomllib.loads((SCENARIOS / "notomista-cai-2020.toml").read_text()))


def header(source: str, sequence: int, *, epoch: int = 1, at_ns: int = 0) -> Header:
    return Header(source, epoch, sequence, at_ns, at_ns, at_ns, at_ns)


def radius(t: float) -> float:
    return 1.5 + 0.3 * cos(2 * t)


def position(t: float) -> tuple[float, float]:
    return radius(t) * cos(t), radius(t) * sin(t)


def h(t: float) -> float:
    return radius(t) ** 2 - 1.0


def power_margin(t: float) -> float:
    return 0.5 + 0.4 * cos(t)


def tick(k: int, **changes: Any) -> FilterTick:  # noqa: ANN401 - any field
    """Filter tick number k of the closed form, for plant time k ms."""
    t = k * 1e-3
    values: dict[str, Any] = {
        "tick": k,
        "status": FilterStatus.MODIFIED if sin(t) > 0 else FilterStatus.PASSED,
        "mode": "both",
        "law": "sampled",
        "effective_plant_ns": k * MS,
        "x_hat": (*position(t), 0.0, 0.0),
        "u_h": (-3.0, 0.0),
        "u_h_rate": (0.0, 0.0),
        "u_nominal": (-1.0, 0.5),
        "phi": (0.0, 0.0),
        "v": (0.0, 0.0),
        "u": (-0.5, 0.25),
        "barriers": (BarrierReport("disk", (h(t), 10 * h(t), 100 * h(t))),),
        "power_margin": power_margin(t),
        "tank_j": 1.0 + 0.1 * sin(t),
        "slack": 0.0,
        "rows": (RowReport("disk", 0.02, 0.4, True, 1.0), RowReport("passivity", 1.3, 0.0, False)),
        "certificate": Certificate("piqp", True, 1e-9, 2e-9, 3e-10),
        "consumed": (Consumed(topic="state", sequence=k, received_ns=k * MS, epoch=1),),
        "state_age_ns": MS + 200_000,
        "command_age_ns": 2 * MS,
        "override": OverrideReport(
            (3.0, 4.0), allowed_fraction=0.625, unavoidable=False, distance_to_infeasibility=12.5
        ),
    }
    return FilterTick(**(values | changes))


def state(k: int, **changes: Any) -> PlantState:  # noqa: ANN401 - any field
    """Plant state of the closed form at plant time k ms."""
    t = k * 1e-3
    values: dict[str, Any] = {
        "plant_ns": k * MS,
        "x": (*position(t), 0.0, 0.0),
        "y": (0.0, 0.0),
        "u": (-0.5, 0.25),
        "applied_tick": max(0, k - 1),
        "phase": PlantPhase.RUNNING,
        "energy_in_j": 0.5,
        "energy_stored_j": 0.25,
        "input_lead_ns": 4 * MS,
        "inputs_late": 0,
        "inputs_refused": 0,
        "integration_error": 0.0,
        "received_tick": k,
    }
    return PlantState(**(values | changes))


def health(steps: int) -> Health:
    return Health(999.5, steps, 3, 1, 412.0, (TopicHealth("state", steps, 2, 1),))


class ClosedFormRun:
    """Messages of the run up to a time: what a reader pushes into a feed, in order of time.

    Args:
        period_ms: Time between two ticks; 1 as in the live system, more for tests that need less work.
        scenario: Configuration that the filter announces; the paper's by default.
    """

    def __init__(self, *, period_ms: int = 1, scenario: Scenario | None = None) -> None:
        self._scenario = paper_scenario() if scenario is None else scenario
        self._next_ms = 0
        self._period_ms = period_ms
        self._sequence = 0

    def until(self, run_ns: int) -> list[tuple[Header, Message, int]]:
        """Messages since the call before, as (header, body, arrival after the run's begin in ns)."""
        messages: list[tuple[Header, Message, int]] = []
        for k in range(self._next_ms, run_ns // MS, self._period_ms):
            at = k * MS
            if k == 0:
                info = ScenarioInfo(self._scenario.model_dump_json(), "live", "{}")
                messages.append((header("filter", 0), info, at))
            if k % 1000 == 0:
                number = k // 1000
                sources = ("router", "plant", "filter", "operator", "recorder")
                messages += [(header(source, number), health(k), at) for source in sources]
                messages.append((header("filter", number), Event("info", f"second {number}"), at))
            if k % 700 == 699:
                event = LinkEvent("plant-to-filter", "dropped", "state", k)
                messages.append((header("filter", k // 700), event, at))
            messages.append((header("plant", self._sequence), state(k), at))
            messages.append((header("filter", self._sequence), tick(k), at))
            self._sequence += 1
            self._next_ms = k + self._period_ms
        return messages
