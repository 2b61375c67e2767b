"""Times one filter step with 20 rows, certificate included, at 2 and at 7 inputs.

``python benchmarks/filter_rows.py``. Points of m dimensions between 19 half-spaces, with a passivity row; states are
drawn from the inside of all of them, and the operator pushes so that rows bind.
"""

from collections.abc import Sequence
from functools import partial
from statistics import median
from typing import Annotated

import casadi as ca
import numpy as np
import typer
from report import AsJson, Ratio, Report, Smallest, spread
from timing import Times, call_times_us, in_turn

from passafe import Barrier, FilterDesign, Linear, Passivity, SafetyPassivityFilter, System, half_plane

ROWS = 20
INPUTS = (2, 7)

Request = tuple[Sequence[float], Sequence[float], Sequence[float], Sequence[float]]
"""Arguments x, u, u_h and u̇_h of a decision."""


def main(
    states: Annotated[int, typer.Option(min=10, max=5000, help="States inside all walls.")] = 400,
    rounds: Annotated[int, typer.Option(min=1, max=100, help="Rounds.")] = 9,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time decisions on damped points of 2 and 7 dimensions between many walls."""
    if smallest:
        states, rounds = 20, 1
    report = Report(
        title=f"One filter step, {ROWS} rows, {states} states, {rounds} rounds",
        columns=("inputs", "p50 µs", "p99 µs", "with an active row", "solvers"),
    )
    problems = [walled_point(m, states) for m in INPUTS]
    times = in_turn([partial(call_times_us, walled.decide, requests) for walled, requests in problems], rounds + 1)
    medians = [[float(np.percentile(round_us, 50)) for round_us in of[1:]] for of in times]
    for m, (walled, requests), p50_us, of in zip(INPUTS, problems, medians, times, strict=True):
        decisions = [walled.decide(x, u, u_h, u_h_rate) for x, u, u_h, u_h_rate in requests]
        uncertified = sum(decision.status.is_fallback for decision in decisions)
        if uncertified:
            report.failures.append(f"answers at {m} inputs: got {uncertified} without a certificate, allowed none")
        active = sum(decision.duals.max() > 1e-6 for decision in decisions) / len(decisions)
        p99_us = median(float(np.percentile(round_us, 99)) for round_us in of[1:])
        solvers = ", ".join(sorted({decision.solver for decision in decisions}))
        report.rows.append((f"{m}", spread(p50_us), f"{p99_us:.1f}", f"{active:.0%}", solvers))
    few, many = medians
    report.ratios.append(Ratio.of_rounds(f"{INPUTS[1]} inputs", many, f"{INPUTS[0]} inputs", few))
    report.finish(as_json=as_json)


def walled_point(m: int, states: int) -> tuple[SafetyPassivityFilter, list[Request]]:
    """Return a filter with ``ROWS`` rows for m inputs, and requests at states inside all its walls."""
    rng = np.random.default_rng(m)
    x, u = ca.SX.sym("x", 2 * m), ca.SX.sym("u", m)
    position, velocity = x[:m], x[m:]
    gains = (Linear(gain=5.0), Linear(gain=5.0), Linear(gain=5.0))
    normals = rng.normal(size=(ROWS - 1, m))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    walls = [half_plane(position, normal=tuple(normal), offset=-1.0) for normal in normals]
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(velocity, -velocity + u), y=velocity),
        u_fb=-4 * position - 2 * velocity,
        fail_safe=-4 * velocity,
        barriers=tuple(Barrier(name=f"wall {i}", h=wall, class_k=gains) for i, wall in enumerate(walls)),
        passivity=Passivity(V=ca.sumsqr(x) / 2, slack_weight=1e4),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=100.0,
    )
    walled = SafetyPassivityFilter(design)
    inside = ca.Function("inside", [x], [ca.vertcat(*(psi for chain in walled.chains for psi in chain.psi[:-1]))])
    requests: list[Request] = []
    while len(requests) < states:
        state: Times = np.concatenate((rng.uniform(-1, 1, m), rng.uniform(-1, 1, m)))
        if float(inside(state).full().min()) > 0:
            u_h = rng.uniform(-300, 300, m).tolist()
            requests.append((state.tolist(), rng.uniform(-1, 1, m).tolist(), u_h, [0.0] * m))
    return walled, requests


if __name__ == "__main__":
    typer.run(main)
