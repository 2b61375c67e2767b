"""The closed-form run of ``closed_form`` as arrays, and the verdict of a review of it."""

from typing import Any

import numpy as np
from barrier_examples import disk
from closed_form import h, position, power_margin
from passafe_dashboard.run_series import RunSeries, StatusSpan
from passafe_protocol.messages import FilterStatus


def run_series(samples: int = 10_000) -> RunSeries:
    t = np.arange(samples) * 1e-3
    x = np.vstack([np.array([position(time) for time in t]).T, np.zeros((2, samples))])
    return RunSeries(
        times_s=t,
        x=x,
        u=np.zeros((2, samples)),
        h=np.array([[h(time) for time in t]]),
        power_margin_w=np.array([power_margin(time) for time in t]),
        barriers=(disk("disk"),),
        statuses=(
            StatusSpan(FilterStatus.PASSED, 0.0, 4.0),
            StatusSpan(FilterStatus.INFEASIBLE, 4.0, 4.002),
        ),
    )


def verdict(**changes: Any) -> dict[str, Any]:  # noqa: ANN401 - any field
    values: dict[str, Any] = {
        "scenario": "circle",
        "mode": "both",
        "law": "sampled",
        "driver": "live",
        "duration_s": 9.999,
        "ticks": 10_000,
        "steps_skipped": 3,
        "gaps": {"state": 0, "tick": 2},
        "h_min": 0.44,
        "power_margin_min": 0.1,
        "tank_min_j": 0.9,
        "u_norm_max": 0.0,
        "status_counts": {"PASSED": 9998, "INFEASIBLE": 2},
        "final_x": [-1.5, 0.25, 0.0, -0.0001],
        "timing": {
            "solve_us": {"p50": 21.5, "p99": 80.25, "p99_9": 120.0, "max": 400.0},
            "late_us": {"filter": {"p50": 70.0, "p99": 300.0, "p99_9": 900.0, "max": 1500.0}},
            "command_age_ms": None,
            "operator_to_plant_ms": None,
        },
        "properties": {
            "safe": {"holds": True, "required": True, "worst": 0.44, "at_s": 1.571, "requirement": "h ≥ -0.001"},
            "passive": {"holds": False, "required": True, "worst": -0.2, "at_s": 3.142, "requirement": "h_u ≥ -0.05"},
            "certified": {"holds": None, "required": False, "worst": None, "at_s": None, "requirement": "all"},
        },
        "verdict": "fails",
    }
    return values | changes
