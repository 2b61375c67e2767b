"""One filter step with 20 rows, certificate included, at 2 and at 7 inputs.

``python benchmarks/filter_rows.py``. Points of m dimensions between 19 half-spaces, with a passivity row; states are
drawn from the inside of all of them, and the operator pushes so that rows bind.
"""

import gc
import os
from statistics import median
from time import perf_counter_ns
from typing import Annotated

import casadi as ca
import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from passafe import Barrier, FilterDesign, Linear, Passivity, SafetyPassivityFilter, System, half_plane
from passafe.workspace import Array

ROWS = 20
STATES = 400


def main(
    rounds: Annotated[int, typer.Option(min=1, max=100, help="Rounds; the median of their medians counts.")] = 9,
) -> None:
    """Time decisions on damped points of 2 and 7 dimensions between many walls."""
    table = Table(title=f"One filter step, {ROWS} rows, {STATES} states, load {os.getloadavg()[0]:.1f}")
    for column in ("inputs", "p50 µs (min–max of rounds)", "p99 µs", "with an active row", "solvers"):
        table.add_column(column)
    for m in (2, 7):
        made, requests = problem(m)
        decisions = [made.decide(*request) for request in requests]
        active = sum(decision.duals.max() > 1e-6 for decision in decisions) / len(decisions)
        solvers = sorted({decision.solver for decision in decisions})
        medians, late = [], []
        for _ in range(rounds):
            times = timed(made, requests)
            medians.append(median(times))
            late.append(float(np.percentile(times, 99)))
        spread = f"{median(medians):.1f} ({min(medians):.1f}–{max(medians):.1f})"
        table.add_row(f"{m}", spread, f"{median(late):.1f}", f"{active:.0%}", ", ".join(solvers))
    Console(width=110).print(table)


def problem(m: int) -> tuple[SafetyPassivityFilter, list[tuple[list[float], ...]]]:
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
    made = SafetyPassivityFilter(design)
    inside = ca.Function("inside", [x], [ca.vertcat(*(psi for chain in made.chains for psi in chain.psi[:-1]))])
    requests: list[tuple[list[float], ...]] = []
    while len(requests) < STATES:
        state: Array = np.concatenate((rng.uniform(-1, 1, m), rng.uniform(-1, 1, m)))
        if float(inside(state).full().min()) > 0:
            u_h = rng.uniform(-300, 300, m).tolist()
            requests.append((state.tolist(), rng.uniform(-1, 1, m).tolist(), u_h, [0.0] * m))
    return made, requests


def timed(made: SafetyPassivityFilter, requests: list[tuple[list[float], ...]]) -> list[float]:
    """Return how long each request takes, µs."""
    gc.collect()
    gc.disable()
    times = []
    for request in requests:
        begin = perf_counter_ns()
        made.decide(*request)
        times.append((perf_counter_ns() - begin) / 1e3)
    gc.enable()
    return times


if __name__ == "__main__":
    typer.run(main)
