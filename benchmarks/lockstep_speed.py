"""Measures how many times real time the lockstep loop runs, recording off.

``python benchmarks/lockstep_speed.py``. Loops in every mode of the filter, and one over a bad network, take turns on
one core with nothing watching. The share of each node is measured in runs of its own, with a clock around every node's
step; the clock's own cost is measured and subtracted.
"""

import os
from collections.abc import Sequence
from functools import partial
from statistics import median
from time import perf_counter_ns, thread_time_ns
from typing import Annotated, NamedTuple

import typer
from passafe_protocol.messages import Received
from passafe_services.cli.options import RateOption, scenario_from_options
from passafe_services.filter.build import filter_node
from passafe_services.loop.lockstep import Lockstep
from passafe_services.node import Node, Outgoing
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.schema import Scenario
from report import AsJson, Ratio, Report, Smallest, spread
from timing import in_turn, without_collector

MODES = ("off", "safe", "passive", "both")
BAD_LINKS = [f"{link}:delay=0.1,jitter=0.02,loss=0.1" for link in ("plant-to-filter", "filter-to-plant")]
WARM_UP_STEPS = 100
CLOCK_READINGS = 10_000


class RunTimes(NamedTuple):
    """Times of one run: wall-clock and CPU time of a period, µs."""

    wall_us: float
    cpu_us: float


class Clocked:
    """Puts a clock around a node's steps.

    Attributes:
        name: The node's.
        subscribes: The node's.
        spent_ns: Time in ``step`` so far, the clock's included.
    """

    def __init__(self, node: Node) -> None:
        """Wrap a node."""
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
    rounds: Annotated[int, typer.Option(min=1, max=100, help="Timed runs of each loop.")] = 7,
    periods: Annotated[int, typer.Option(min=10, help="Periods of each run.")] = 10_000,
    rate: RateOption = None,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Time the lockstep loop in every mode, and over a bad network."""
    if smallest:
        rounds, periods = 1, 50
    use_one_core()
    loops = {mode: scenario_from_options(scenario, mode=mode, rate_hz=rate) for mode in MODES}
    loops["both, bad network"] = scenario_from_options(scenario, mode="both", rate_hz=rate, links=BAD_LINKS)
    timed = in_turn([partial(run_times, loaded, periods) for loaded in loops.values()], rounds)
    shares = [node_times_us(loaded, periods) for loaded in loops.values()]
    report = Report(
        title=f"Lockstep, {scenario}, {rounds} runs of {periods} periods",
        columns=("loop", "× real time", "CPU µs a period", "on core", *(f"{name} µs" for name in shares[0])),
    )
    for (name, loaded), times, share in zip(loops.items(), timed, shares, strict=True):
        factors = [period_ns(loaded) / 1e3 / each.wall_us for each in times]
        on_core = sum(each.cpu_us for each in times) / sum(each.wall_us for each in times)
        cpu_us = f"{median(each.cpu_us for each in times):.1f}"
        row = (name, spread(factors), cpu_us, f"{on_core:.0%}", *(f"{us:.1f}" for us in share.values()))
        report.rows.append(row)
    off, *_, both, bad = [[each.cpu_us for each in times] for times in timed]
    report.ratios.append(Ratio.of_rounds("both", both, "off", off))
    report.ratios.append(Ratio.of_rounds("both, bad network", bad, "both", both))
    report.finish(as_json=as_json)


def use_one_core() -> None:
    """Stay on the highest core allowed, where the system lets a process choose."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def loop_nodes(scenario: Scenario) -> list[Node]:
    """Return the nodes of the loop in the order in which they step."""
    return [plant_node(scenario), operator_node(scenario, 1), filter_node(scenario, "lockstep", 1)]


def warm_loop(nodes: Sequence[Node], scenario: Scenario) -> Lockstep:
    """Return the scenario's loop of some nodes, over its links, after a few periods."""
    loop = Lockstep(nodes, period_ns=period_ns(scenario), links=link_settings(scenario))
    loop.run(WARM_UP_STEPS)
    return loop


def run_times(scenario: Scenario, periods: int) -> RunTimes:
    """Return what one run takes."""
    loop = warm_loop(loop_nodes(scenario), scenario)
    wall_ns, cpu_ns = perf_counter_ns(), thread_time_ns()
    loop.run(periods)
    return RunTimes((perf_counter_ns() - wall_ns) / periods / 1e3, (thread_time_ns() - cpu_ns) / periods / 1e3)


def node_times_us(scenario: Scenario, periods: int) -> dict[str, float]:
    """Return the time of each node's step and what remains for the driver, µs a period."""
    clock_ns = clock_cost_ns()
    clocked = [Clocked(node) for node in loop_nodes(scenario)]
    loop = warm_loop(clocked, scenario)
    before = [node.spent_ns for node in clocked]
    begin = perf_counter_ns()
    loop.run(periods)
    wall_ns = perf_counter_ns() - begin - periods * len(clocked) * 2 * clock_ns
    spent = {
        node.name: (node.spent_ns - start) / periods - clock_ns for node, start in zip(clocked, before, strict=True)
    }
    spent["loop"] = wall_ns / periods - sum(spent.values())
    return {name: time_ns / 1e3 for name, time_ns in spent.items()}


def clock_cost_ns() -> float:
    """Return how long one reading of the clock takes, ns."""
    with without_collector():
        begin = perf_counter_ns()
        for _ in range(CLOCK_READINGS):
            perf_counter_ns()
        return (perf_counter_ns() - begin) / CLOCK_READINGS


if __name__ == "__main__":
    typer.run(main)
