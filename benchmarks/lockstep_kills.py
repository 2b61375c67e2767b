"""Kills filter, router or a link at a random moment, in virtual time, a thousand times: h ≥ 0, and the loop resumes.

``python benchmarks/lockstep_kills.py``. Each seed decides a scenario, a safe start, an adversary operator, the delay
of the robot's links, what is killed, when and for how long. A killed filter loses its memory and the messages in flight
to it, and is started again as another session; a killed router is an outage of every link, a killed link of one.
"""

from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from statistics import median
from typing import Annotated, Any, Final

import numpy as np
import typer
from passafe_protocol.messages import PlantPhase
from passafe_services.filter.build import filter_node
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.campaign.safe_starts import SafeStarts
from passafe_services.tools.experiment.metrics import metrics_of
from passafe_services.tools.experiment.run_trace import RunTrace
from passafe_services.tools.experiment.runner import CompiledStudy
from report import AsJson, Report, Smallest
from rich.console import Console
from rich.progress import track

SCENARIOS: Final = ("notomista-cai-2020", "walls-and-disks")
STRATEGIES: Final = ("piecewise-constant", "chirp", "bang-bang", "against-h", "against-the-tank")
LINKS: Final = ("operator-to-filter", "filter-to-plant", "plant-to-filter", "plant-to-operator")
VICTIMS: Final = ("filter", "router", *LINKS[:3])
RATE_HZ: Final = 500.0
RUN_S: Final = 5.0
RESUMED_WITHIN_S: Final = 2.0
"""Time after the victim's return from which the plant must apply inputs for good; links delay by 0.4 s at most."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Kill:
    """Outcome of one kill.

    Attributes:
        seed: Seed that it can be run again with.
        scenario: Name.
        victim: What was killed.
        h_min: Smallest barrier value, at and between samples.
        tank_min_j: Smallest energy in the tank, J.
        broke: Whether the plant had to hold or fail safe after the kill.
        resumed_after_s: From the victim's return until the plant applied inputs for good, s; ``None`` if it never did.
    """

    seed: int
    scenario: str
    victim: str
    h_min: float
    tank_min_j: float
    broke: bool
    resumed_after_s: float | None


def main(
    kills: Annotated[int, typer.Option(min=1, help="How many.")] = 1000,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Kill, and report the worst that happened; exits with 1 if h < 0 or the robot did not resume."""
    if smallest:
        kills, workers = 3, 1
    seeds = range(first_seed, first_seed + kills)
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        done = track(pool.map(kill, seeds, chunksize=8), total=kills, console=Console(stderr=True), description="kills")
        found = list(done)
    report = Report(
        title=f"{kills} kills in virtual time at {RATE_HZ:g} Hz, seeds from {first_seed} on",
        columns=("victim", "kills", "h < 0", "lowest h (seed)", "lowest tank, J", "breaks", "resumed after: p50, max"),
    )
    for victim, count in Counter(each.victim for each in found).items():
        report.rows.append(row(victim, count, [each for each in found if each.victim == victim]))
    for each in found:
        if not each.h_min >= 0:
            report.failures.append(f"lowest h of seed {each.seed}: got {each.h_min}, allowed 0 or more")
        if each.resumed_after_s is None:
            report.failures.append(f"seed {each.seed} did not resume within {RESUMED_WITHIN_S} s")
    report.finish(as_json=as_json)


def kill(seed: int) -> Kill:
    """Return the outcome of one seed's kill."""
    rng = np.random.default_rng([seed, 0x61])
    name, victim = str(rng.choice(SCENARIOS)), str(rng.choice(VICTIMS))
    study, starts = compiled_study(name)
    at_s, down_s = float(rng.uniform(0.05, 3.0)), float(10 ** rng.uniform(-2.5, 0.0))
    scenario = drawn(name, rng, starts, {} if victim == "filter" else outage(victim, at_s, down_s))
    trace = RunTrace(study.compiled.filter.core)
    loop = lockstep_loop(scenario, taps=trace.taps, compiled=study.compiled)
    before, down, rest = (round(t * RATE_HZ) for t in (at_s, down_s, RUN_S))
    loop.run(before)
    if victim == "filter":
        loop.kill("filter")
    loop.run(down)
    if victim == "filter":
        loop.restart(filter_node(scenario, "lockstep", 2, study.compiled.model, study.compiled.filter), 2)
    loop.run(rest)
    metrics = metrics_of(scenario, trace, study.evaluator, study.motion, None)
    assert metrics.h_min is not None, "a run without a sample"  # noqa: S101 - a benchmark may
    assert metrics.tank_min_j is not None, "a run without a sample"  # noqa: S101 - a benchmark may
    unserved = np.flatnonzero(trace.phases()[-rest:] != PlantPhase.RUNNING)
    resumed_after_s = (unserved[-1] + 1) / RATE_HZ if unserved.size else 0.0
    return Kill(
        seed=seed,
        scenario=name,
        victim=victim,
        h_min=metrics.h_min,
        tank_min_j=metrics.tank_min_j,
        broke=metrics.held_s + metrics.fail_safe_s > 0,
        resumed_after_s=resumed_after_s if resumed_after_s < RESUMED_WITHIN_S else None,
    )


@cache
def compiled_study(name: str) -> tuple[CompiledStudy, SafeStarts]:
    """Return the compiled scenario and its safe starts, made once in each process."""
    scenario = load_scenario(name, {"rate_hz": RATE_HZ})
    study = CompiledStudy(scenario)
    return study, SafeStarts(scenario, study.compiled.filter.core)


def drawn(name: str, rng: np.random.Generator, starts: SafeStarts, outages: dict[str, Any]) -> Scenario:
    """Return a scenario with random start, operator and delays."""
    overrides: dict[str, Any] = {
        "rate_hz": RATE_HZ,
        "plant.x0": starts.draw(rng).tolist(),
        "operator.source": {
            "kind": "adversary",
            "strategy": str(rng.choice(STRATEGIES)),
            "seed": int(rng.integers(2**31)),
        },
    }
    for link in LINKS[1:3]:
        overrides[f"links.{link}.delay_s"] = float(rng.uniform(0.0, 0.2))
    return load_scenario(name, overrides | outages)


def outage(victim: str, at_s: float, down_s: float) -> dict[str, Any]:
    """Return the outage that stands for a dead router or link: its times count from the link's first message."""
    dead = LINKS if victim == "router" else (victim,)
    return {f"links.{link}.outages_s": [[at_s, at_s + down_s]] for link in dead}


def row(victim: str, count: int, kills: Sequence[Kill]) -> tuple[str, ...]:
    """Return the table's row of one victim."""
    worst = min(kills, key=lambda each: each.h_min)
    resumed_s = [each.resumed_after_s for each in kills if each.resumed_after_s is not None]
    return (
        victim,
        f"{count}",
        f"{sum(each.h_min < 0 for each in kills)}",
        f"{worst.h_min:.2g} ({worst.seed})",
        f"{min(each.tank_min_j for each in kills):.3g}",
        f"{sum(each.broke for each in kills)}",
        f"{median(resumed_s):.2f} s, {max(resumed_s):.2f} s" if resumed_s else "never",
    )


if __name__ == "__main__":
    typer.run(main)
