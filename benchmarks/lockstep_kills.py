"""Filter, router or a link dies at a random moment, in virtual time, a thousand times: h ≥ 0, and the loop goes on.

``python benchmarks/lockstep_kills.py``. Each seed decides a scenario, a safe start, an adversary who drives, the delay
of the robot's links, what is killed, when and for how long. A killed filter loses all that it knew and what was under
way to it, and is started again as another session; a killed router is an outage of every link, a killed link of one.
"""

import json
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import cache
from multiprocessing import get_context
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
from rich.console import Console
from rich.progress import track
from rich.table import Table

SCENARIOS: Final = ("notomista-cai-2020", "walls-and-disks")
STRATEGIES: Final = ("piecewise-constant", "chirp", "bang-bang", "against-h", "against-the-tank")
LINKS: Final = ("operator-to-filter", "filter-to-plant", "plant-to-filter", "plant-to-operator")
VICTIMS: Final = ("filter", "router", *LINKS[:3])
RATE_HZ: Final = 500.0
RUN_S: Final = 5.0
BACK_S: Final = 2.0
"""How long after the victim is back the robot has to be armed again, at the latest; links delay by 0.4 s at most."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Kill:
    """What one kill came to.

    Attributes:
        seed: What it can be run again with.
        scenario: Name.
        victim: What died.
        h_min: Smallest barrier value, at and between samples.
        tank_min_j: Smallest energy in the tank, J.
        disarmed: Whether the plant had to hold or fail safe after the kill.
        back_s: From the victim's return until the robot was armed for good, s; ``None`` if it never was.
    """

    seed: int
    scenario: str
    victim: str
    h_min: float
    tank_min_j: float
    disarmed: bool
    back_s: float | None


def main(
    kills: Annotated[int, typer.Option(min=1, help="How many.")] = 1000,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = 2,
    as_json: Annotated[bool, typer.Option("--json", help="Print every kill as JSON.")] = False,
) -> None:
    """Kill, and tell the worst that happened; exits with 1 if h < 0 or the robot was not armed again."""
    seeds = range(first_seed, first_seed + kills)
    console = Console(stderr=as_json)
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        found = list(track(pool.map(kill, seeds, chunksize=8), total=kills, console=console, description="killing"))
    if as_json:
        typer.echo(json.dumps([asdict(each) for each in found], indent=2))
    else:
        show(found, console)
    raise typer.Exit(0 if all(each.h_min >= 0 and each.back_s is not None for each in found) else 1)


def kill(seed: int) -> Kill:
    """Return what the kill of one seed came to."""
    rng = np.random.default_rng([seed, 0x61])
    name, victim = str(rng.choice(SCENARIOS)), str(rng.choice(VICTIMS))
    kit, starts = kit_of(name)
    at_s, down_s = float(rng.uniform(0.05, 3.0)), float(10 ** rng.uniform(-2.5, 0.0))
    scenario = drawn(name, rng, starts, {} if victim == "filter" else outage(victim, at_s, down_s))
    tape = RunTrace(kit.compiled.filter.core)
    loop = lockstep_loop(scenario, taps=tape.taps, compiled=kit.compiled)
    before, down, rest = (round(t * RATE_HZ) for t in (at_s, down_s, RUN_S))
    loop.run(before)
    if victim == "filter":
        loop.kill("filter")
    loop.run(down)
    if victim == "filter":
        loop.restart(filter_node(scenario, "lockstep", 2, kit.compiled.model, kit.compiled.filter), 2)
    loop.run(rest)
    figures = metrics_of(scenario, tape, kit.mathematics, kit.motion, None)
    assert figures.h_min is not None, "a run without a sample"  # noqa: S101 - a benchmark may
    assert figures.tank_min_j is not None, "a run without a sample"  # noqa: S101 - a benchmark may
    unserved = np.flatnonzero(tape.phases()[-rest:] != PlantPhase.RUNNING)
    back_s = (unserved[-1] + 1) / RATE_HZ if unserved.size else 0.0
    return Kill(
        seed=seed,
        scenario=name,
        victim=victim,
        h_min=figures.h_min,
        tank_min_j=figures.tank_min_j,
        disarmed=figures.held_s + figures.fail_safe_s > 0,
        back_s=back_s if back_s < BACK_S else None,
    )


@cache
def kit_of(name: str) -> tuple[CompiledStudy, SafeStarts]:
    """Return what is derived from a scenario, once in each process."""
    scenario = load_scenario(name, {"rate_hz": RATE_HZ})
    kit = CompiledStudy(scenario)
    return kit, SafeStarts(scenario, kit.compiled.filter.core)


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


def show(found: Sequence[Kill], console: Console) -> None:
    """Print a row for each victim."""
    table = Table(
        "victim", "kills", "h < 0", "lowest h (seed)", "lowest tank, J", "disarmed", "back after, s: p50, max"
    )
    for victim, count in Counter(each.victim for each in found).items():
        of = [each for each in found if each.victim == victim]
        worst = min(of, key=lambda each: each.h_min)
        back = [each.back_s for each in of if each.back_s is not None]
        lost = f", {len(of) - len(back)} NEVER" if len(back) < len(of) else ""
        table.add_row(
            victim,
            f"{count}",
            f"{sum(each.h_min < 0 for each in of)}",
            f"{worst.h_min:.2g} ({worst.seed})",
            f"{min(each.tank_min_j for each in of):.3g}",
            f"{sum(each.disarmed for each in of)}",
            f"median {np.median(back):.2f}, most {max(back):.2f}{lost}",
        )
    console.print(table)


if __name__ == "__main__":
    typer.run(main)
