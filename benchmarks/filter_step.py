"""Times one filter step, state in → certified u out, beside other libraries.

``python benchmarks/filter_step.py``. The states lie along a closed loop of the reference scenario, mode ``both``,
without margins between samples, which no peer has: all solve the program of ``filter_contenders.py``. Before anything
is timed, every contender's answers are compared with ours.
"""

from collections.abc import Sequence
from functools import partial
from importlib import import_module
from statistics import median

import numpy as np
import typer
from filter_contender_cbfpy import CbfpyWithElastiqp
from filter_contender_solvers import CVXPY_SOLVERS, DaqpAlone, ParametrisedCvxpy
from filter_contenders import Contender, Passafe, Request
from passafe_services.operator.sources.scenario_source import source_of
from passafe_services.scenarios.design import robot_of, sampled_plant_of
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from report import AsJson, Ratio, Report, Rounds, Smallest, States, spread
from timing import Times, call_times_us, in_turn

from passafe import Status

SCOUTED = 50
"""States on which the solvers behind cvxpy are tried."""


def main(
    states: States = 500,
    rounds: Rounds = 15,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time one filter step beside cbfpy with elastiqp, cvxpy and DAQP."""
    if smallest:
        states, rounds = 50, 1
    scenario = load_scenario("notomista-cai-2020", {"filter.mode": "both"})
    ours = Passafe(scenario, margins=False)
    requests, active = sample_requests(scenario, ours, states)
    solvers = fastest_cvxpy(scenario, requests[:: max(1, len(requests) // SCOUTED)])
    contenders: list[Contender] = [ours, Passafe(scenario, margins=True), CbfpyWithElastiqp(scenario)]
    contenders += [solvers, DaqpAlone(scenario)]
    report = Report(
        title=f"One filter step: {states} states, {active:.0%} with an active row, {rounds} rounds",
        columns=("", "p50 µs", "p99 µs", "largest ‖Δu⁺‖/(1+‖u⁺‖)"),
    )
    differences = [worst_difference(ours, contender, requests) for contender in contenders]
    times = timed(contenders, requests, rounds)
    p50 = [[float(np.percentile(round_us, 50)) for round_us in of] for of in times]
    for contender, difference, p50_us, of in zip(contenders, differences, p50, times, strict=True):
        p99_us = median(float(np.percentile(round_us, 99)) for round_us in of)
        allowed = (
            "another program" if contender.tolerance is None else f"{difference:.1e} (≤ {contender.tolerance:.0e})"
        )
        report.rows.append((contender.name, spread(p50_us), f"{p99_us:.1f}", allowed))
        report.notes.append(f"{contender.name}: {contender.differs}")
        if contender.name != ours.name:
            report.ratios.append(Ratio.of_rounds(contender.name, p50_us, ours.name, p50[0]))
        if contender.tolerance is not None and not difference <= contender.tolerance:
            report.failures.append(f"answers of {contender.name}: got {difference:.1e}, allowed {contender.tolerance}")
    report.finish(as_json=as_json)


def sample_requests(scenario: Scenario, ours: Passafe, states: int) -> tuple[list[Request], float]:
    """Return requests at equal intervals along a closed loop, and the share of them with an active row."""
    plant = sampled_plant_of(scenario, robot_of(scenario))
    source = source_of(scenario)
    x, u = tuple(scenario.plant.x0), (0.0,) * plant.system.m
    steps = round(scenario.duration_s * scenario.rate_hz)
    chosen = set(np.linspace(0, steps - 1, states, dtype=int).tolist())
    requests, active = [], 0
    for step in range(steps):
        command = source.command(step * scenario.dt_s)
        request = Request(x, u, command.u_h, command.u_h_rate)
        decision = ours.step(*request)
        if step in chosen:
            requests.append(request)
            active += decision.status is not Status.PASSED
        u = decision.u
        x = plant.advance(x, u).x
    return requests, active / len(requests)


def fastest_cvxpy(scenario: Scenario, requests: Sequence[Request]) -> Contender:
    """Return cvxpy with the solver that is fastest on some of the states."""
    installed: list[str] = import_module("cvxpy").installed_solvers()
    candidates = [ParametrisedCvxpy(scenario, solver) for solver in CVXPY_SOLVERS if solver in installed]
    medians = [float(np.median(of)) for of in timed(candidates, requests, 3)]
    return candidates[medians.index(min(medians))]


def worst_difference(ours: Passafe, contender: Contender, requests: Sequence[Request]) -> float:
    """Return the largest distance of a contender's u⁺ from ours, relative to 1 + ‖u⁺‖."""
    worst = 0.0
    for request in requests:
        expected = np.array(ours.step(*request).u)
        got = np.array(contender.answer(contender.step(*contender.prepare(request))))
        worst = max(worst, float(np.linalg.norm(got - expected) / (1 + np.linalg.norm(expected))))
    return worst


def timed(contenders: Sequence[Contender], requests: Sequence[Request], rounds: int) -> list[list[Times]]:
    """Return the times of all calls, µs, for each contender and round, after a round of warm-up."""
    prepared = [[contender.prepare(request) for request in requests] for contender in contenders]

    def measure(i: int) -> Times:
        return call_times_us(contenders[i].step, prepared[i])

    return [of[1:] for of in in_turn([partial(measure, i) for i in range(len(contenders))], rounds + 1)]


if __name__ == "__main__":
    typer.run(main)
