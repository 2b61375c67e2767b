"""How many times real time the lockstep loop runs, recording off.

``python benchmarks/lockstep_speed.py``; over a bad network with ``--link``. Timed runs come first, on one core, with
nothing watching. The share of each node is then measured in runs of its own, with a clock around every node's step; the
clock's own cost is measured and taken off.
"""

import gc
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from statistics import median
from time import perf_counter_ns, thread_time_ns
from typing import Annotated, Any

import typer
from passafe_protocol.messages import Received
from passafe_services.cli.options import LinkOption, RateOption, scenario_from_options
from passafe_services.filter.build import filter_node
from passafe_services.loop.lockstep import Lockstep
from passafe_services.node import Node, Outgoing
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.schema import Scenario
from rich.console import Console
from rich.table import Table

MODES = ("off", "safe", "passive", "both")
WARM_UP_STEPS = 100


@dataclass(frozen=True, kw_only=True, slots=True)
class Speed:
    """Figures of one mode.

    Attributes:
        mode: The filter's mode.
        times_real_time: Virtual over wall-clock time of every repetition, in order.
        tick_us: Wall-clock time of one period of the whole loop, µs: median over repetitions.
        on_core: CPU time over wall-clock time, all repetitions; well below 1 means that others had the core.
        node_us: Time of each node's step, µs, and ``loop`` for what the driver adds; from separate runs.
    """

    mode: str
    times_real_time: tuple[float, ...]
    tick_us: float
    on_core: float
    node_us: dict[str, float]


class Clocked:
    """A node with a clock around its steps.

    Attributes:
        name: The node's.
        subscribes: The node's.
        spent_ns: Time in ``step`` so far, the clock's included.
    """

    def __init__(self, node: Node) -> None:
        self.name, self.subscribes, self.spent_ns = node.name, node.subscribes, 0
        self._step = node.step

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Step the node."""
        begin = perf_counter_ns()
        outgoing = self._step(now_ns, inbox)
        self.spent_ns += perf_counter_ns() - begin
        return outgoing


def main(
    scenario: Annotated[str, typer.Option(help="Scenario, by name or file.")] = "notomista-cai-2020",
    repetitions: Annotated[int, typer.Option(min=1, max=100, help="Timed runs for each mode.")] = 7,
    mode: Annotated[list[str] | None, typer.Option(help=f"Of {', '.join(MODES)}; all if not given.")] = None,
    rate: RateOption = None,
    link: LinkOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of the table.")] = False,
) -> None:
    """Time the lockstep loop in every mode."""
    core = use_one_core()
    unknown = sorted(set(mode or ()) - set(MODES))
    if unknown:
        raise typer.BadParameter(f"got {', '.join(unknown)}, allowed {', '.join(MODES)}", param_hint="--mode")
    scenarios = {
        name: scenario_from_options(scenario, mode=name, rate_hz=rate, links=link or ()) for name in mode or MODES
    }
    speeds = [measure(loaded, name, repetitions) for name, loaded in scenarios.items()]
    load = os.getloadavg()[0]
    if as_json:
        facts = {
            "scenario": scenario,
            "rate_hz": rate,
            "links": link,
            "core": core,
            "python": sys.version.split()[0],
            "load_average_1min": load,
        }
        print(json.dumps(facts | {"modes": [asdict(speed) for speed in speeds]}, indent=2))
        return
    show(speeds, f"Lockstep, {scenario}, recording off, {repetitions} runs, core {core}, load {load:.1f}")


def use_one_core() -> int | None:
    """Stay on the highest core allowed; return it, or ``None`` where the system has no say in it."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    core = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {core})
    return core


def measure(scenario: Scenario, mode: str, repetitions: int) -> Speed:
    """Return the figures of one mode."""
    steps = round(scenario.duration_s * scenario.rate_hz)
    runs = [timed_run_ns(scenario, steps) for _ in range(repetitions)]
    walls = [wall_ns for wall_ns, _ in runs]
    return Speed(
        mode=mode,
        times_real_time=tuple(steps * period_ns(scenario) / wall for wall in walls),
        tick_us=median(walls) / steps / 1e3,
        on_core=sum(cpu_ns for _, cpu_ns in runs) / sum(walls),
        node_us=shares(scenario, steps),
    )


def loop_nodes(scenario: Scenario) -> list[Node]:
    """Return the nodes of the loop in the order in which they step."""
    return [plant_node(scenario), operator_node(scenario, 1), filter_node(scenario, "lockstep", 1)]


def loop_of(nodes: Sequence[Node], scenario: Scenario) -> Lockstep:
    """Return the scenario's loop of some nodes, over its links."""
    return Lockstep(nodes, period_ns=period_ns(scenario), links=link_settings(scenario))


def timed_run_ns(scenario: Scenario, steps: int) -> tuple[int, int]:
    """Return the wall-clock and the CPU time of some periods after a warm-up, ns."""
    loop = loop_of(loop_nodes(scenario), scenario)
    loop.run(WARM_UP_STEPS)
    gc.collect()
    wall_ns, cpu_ns = perf_counter_ns(), thread_time_ns()
    loop.run(steps)
    return perf_counter_ns() - wall_ns, thread_time_ns() - cpu_ns


def shares(scenario: Scenario, steps: int) -> dict[str, float]:
    """Return the time of each node's step and what remains for the driver, µs a period."""
    clock_ns = clock_cost_ns()
    clocked = [Clocked(node) for node in loop_nodes(scenario)]
    loop = loop_of(clocked, scenario)
    loop.run(WARM_UP_STEPS)
    before = [node.spent_ns for node in clocked]
    begin = perf_counter_ns()
    loop.run(steps)
    wall_ns = perf_counter_ns() - begin - steps * len(clocked) * 2 * clock_ns
    spent = {node.name: (node.spent_ns - start) / steps - clock_ns for node, start in zip(clocked, before, strict=True)}
    spent["loop"] = wall_ns / steps - sum(spent.values())
    return {name: time_ns / 1e3 for name, time_ns in spent.items()}


def clock_cost_ns(readings: int = 10_000) -> float:
    """Return how long one reading of the clock takes, ns."""
    begin = perf_counter_ns()
    for _ in range(readings):
        perf_counter_ns()
    return (perf_counter_ns() - begin) / readings


def show(speeds: Sequence[Speed], title: str) -> None:
    """Print the table."""
    names = list(speeds[0].node_us)
    table = Table(title=title)
    for column in (
        "mode",
        "× real time: min",
        "median",
        "max",
        "tick µs",
        "on core",
        *(f"{n} µs" for n in names),
    ):
        table.add_column(column, justify="right")
    for speed in speeds:
        factors = speed.times_real_time
        figures: list[Any] = [min(factors), median(factors), max(factors), speed.tick_us]
        nodes = [f"{speed.node_us[name]:.1f}" for name in names]
        table.add_row(speed.mode, *(f"{figure:.1f}" for figure in figures), f"{speed.on_core:.0%}", *nodes)
    Console(width=max(110, Console().width)).print(table)


if __name__ == "__main__":
    typer.run(main)
