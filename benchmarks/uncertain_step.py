"""Times one filter step with rows for sets beside one with rows for the model alone.

``python benchmarks/uncertain_step.py``. The paper's robot and disk; disturbance, mass, damping and noise together. Each
filter decides along its own closed loop, with an operator who pushes at the disk, so that rows are active.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from statistics import median

import numpy as np
import typer
from passafe_services.scenarios.design import design_of, robot_of, sampled_plant_of, tank_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.uncertain.trials import SETS
from report import AsJson, Ratio, Report, Rounds, Smallest, States, spread
from timing import call_times_us, in_turn

from passafe import SafetyPassivityFilter, Status
from passafe.uncertainty import Uncertainty

Request = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], tuple[float, ...], float]
"""Arguments x, u, u_h, u̇_h and tank_j of a decision."""

LOOPS: dict[str, dict[str, object]] = {
    "disk, safe": {"filter.mode": "safe"},
    "disk, safe and passive": {"filter.mode": "both", "filter.passivity.kind": "tank"},
}
"""Changes of the reference scenario, by name; with a tank, since noise alone makes every instant's power unsure."""


def main(
    states: States = 500,
    rounds: Rounds = 15,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time decisions with and without sets along closed loops."""
    if smallest:
        states, rounds = 30, 1
    report = Report(
        title=f"One filter step with sets: {states} states, {rounds} rounds",
        columns=("rows for", "p50 µs", "p99 µs", "with an active row"),
    )
    for kind, changes in LOOPS.items():
        problems = [loop(changes, sets, states) for sets in (None, SETS["together"])]
        measures = [partial(call_times_us, core.decide, requests) for core, requests, _ in problems]
        times = in_turn(measures, rounds + 1)
        medians = [[float(np.percentile(round_us, 50)) for round_us in of[1:]] for of in times]
        for name, (_, _, active), p50_us, of in zip(("the model", "sets"), problems, medians, times, strict=True):
            p99_us = median(float(np.percentile(round_us, 99)) for round_us in of[1:])
            report.rows.append((f"{kind}, {name}", spread(p50_us), f"{p99_us:.1f}", f"{active:.0%}"))
        model, sets_us = medians
        report.ratios.append(Ratio.of_rounds(f"{kind}, sets", sets_us, f"{kind}, the model", model))
    report.finish(as_json=as_json)


def loop(
    changes: dict[str, object], sets: Uncertainty | None, states: int
) -> tuple[SafetyPassivityFilter, Sequence[Request], float]:
    """Return a filter, requests at equal intervals along its closed loop, and the share of them with an active row."""
    scenario = load_scenario("notomista-cai-2020", changes)
    robot = robot_of(scenario)
    design = design_of(scenario, robot)
    core = SafetyPassivityFilter(design if sets is None else replace(design, uncertainty=sets))
    plant = sampled_plant_of(scenario, robot)
    x: tuple[float, ...] = tuple(scenario.plant.x0)
    u: tuple[float, ...] = (0.0, 0.0)
    u_h, zero = (-3.0, 0.0), (0.0, 0.0)
    tank, sample = tank_of(scenario), plant.at(x)
    tank_j = tank.initial_j
    steps = round(scenario.duration_s * scenario.rate_hz) // 2
    chosen = set(np.linspace(0, steps - 1, states, dtype=int).tolist())
    requests, active = [], 0
    for step in range(steps):
        decision = core.decide(x, u, u_h, zero, tank_j)
        if step in chosen:
            requests.append((x, u, u_h, zero, tank_j))
            active += decision.status is not Status.PASSED
        u, before = decision.u, sample.stored_j
        sample = plant.advance(x, u)
        x, tank_j = sample.x, tank.balance(tank_j, sample.energy_in_j, sample.stored_j - before)
    return core, requests, active / len(requests)


if __name__ == "__main__":
    typer.run(main)
