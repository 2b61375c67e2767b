"""Times one filter step with a gatekeeper whose rollouts are machine code beside one whose rollouts are interpreted.

``python benchmarks/gatekeeper_step.py``. Each scenario's filter decides along its own closed loop, with an operator who
pushes at the limits; both decide alike, to the last bit, or the benchmark fails.
"""

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
import typer
from passafe_services.loop.machine_code import machine_code
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario
from report import AsJson, Ratio, Report, Rounds, Smallest, States, spread
from timing import call_times_us, in_turn

from passafe import FilterDesign, SafetyPassivityFilter
from passafe.sampled_plant import SampledPlant

SCENARIOS: Final = ("notomista-cai-2020", "walls-and-disks", "unicycle-posts")

Request = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], tuple[float, ...], float]
"""Arguments x, u, u_h, u̇_h and tank_j of a decision."""


def main(
    states: States = 60,
    rounds: Rounds = 5,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time decisions with a gatekeeper, interpreted and as machine code, along closed loops."""
    driven_s = 2.0
    if smallest:
        states, rounds, driven_s = 10, 1, 0.02
    report = Report(
        title=f"One filter step with a gatekeeper: {states} states, {rounds} rounds",
        columns=("rollouts", "p50 ms", "p99 ms"),
    )
    for name in SCENARIOS:
        scenario = load_scenario(name)
        design = replace(design_of(scenario, robot_of(scenario)), gatekeeper=True)
        cores = [SafetyPassivityFilter(design), SafetyPassivityFilter(design, compiler=machine_code)]
        requests = loop(design, cores[1], tuple(scenario.plant.x0), states, driven_s)
        if any(cores[0].decide(*request).u != cores[1].decide(*request).u for request in requests):
            report.failures.append(f"{name}: machine code decides otherwise")
        measures = [partial(call_times_us, core.decide, requests) for core in cores]
        times = in_turn(measures, rounds + 1)
        medians = [[float(np.percentile(round_us, 50)) for round_us in of[1:]] for of in times]
        for kind, p50_us, of in zip(("interpreted", "machine code"), medians, times, strict=True):
            p99_us = float(np.median([np.percentile(round_us, 99) for round_us in of[1:]]))
            report.rows.append((f"{name}, {kind}", spread([each / 1e3 for each in p50_us]), f"{p99_us / 1e3:.2f}"))
        interpreted, compiled = medians
        report.ratios.append(Ratio.of_rounds(f"{name}: interpreted", interpreted, "machine code", compiled))
    report.finish(as_json=as_json)


def loop(
    design: FilterDesign, core: SafetyPassivityFilter, x: tuple[float, ...], states: int, driven_s: float
) -> list[Request]:
    """Return requests at equal intervals along some seconds of a closed loop."""
    plant = SampledPlant(design.system, design.passivity.V, design.dt_s)
    u_h, u = tuple(design.limits.magnitude), (0.0,) * design.system.m
    steps = max(states, round(driven_s / design.dt_s))
    chosen = set(np.linspace(0, steps - 1, states, dtype=int).tolist())
    requests: list[Request] = []
    for step in range(steps):
        request = (x, u, u_h, (0.0,) * design.system.m, 1e6)
        u = core.decide(*request).u
        x = plant.advance(x, u).x
        if step in chosen:
            requests.append(request)
    return requests


if __name__ == "__main__":
    typer.run(main)
