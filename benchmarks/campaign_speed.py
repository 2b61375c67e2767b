"""What a tick of an adversarial campaign costs, decided in batches and one by one, side by side in one run.

``python benchmarks/campaign_speed.py``. CPU time of one process, filter, plant, adversaries and h between samples
included; the two ways take turns. The share is that of ticks in a batch which the filter itself had to decide.
"""

import json
from statistics import median
from time import process_time
from typing import Annotated

import typer
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.tools.campaign.rollout import Rollouts
from passafe_services.tools.campaign.rollout_result import RolloutResult
from passafe_services.tools.campaign.workers import BATCH, BATCH_SINGLY
from rich.console import Console
from rich.table import Table
from threadpoolctl import threadpool_limits


def main(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Shipped scenarios; all of them if not given.")] = None,
    ticks: Annotated[int, typer.Option(min=1, help="Ticks of every rollout.")] = 500,
    repeats: Annotated[int, typer.Option(min=1, help="Runs of each way, in turn.")] = 3,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Measure µs a tick of every scenario."""
    figures = {}
    with threadpool_limits(1):
        for name in scenarios or shipped_scenarios():
            figures[name] = measured(name, ticks, repeats)
    if as_json:
        print(json.dumps(figures, indent=2))
        return
    table = Table("scenario", "one by one, µs", f"{BATCH} at once, µs", "ratio", "decided singly")
    for name, (singly_us, at_once_us, share) in figures.items():
        row = (f"{singly_us:.1f}", f"{at_once_us:.2f}", f"{singly_us / at_once_us:.1f}", f"{share:.2%}")
        table.add_row(name, *row)
    Console().print(table)


def measured(name: str, ticks: int, repeats: int) -> tuple[float, float, float]:
    """Return µs a tick one by one, the same in a batch, and the share decided singly there."""
    scenario = load_scenario(name)
    ways = {singly: Rollouts(scenario, singly=singly) for singly in (True, False)}
    spent_us: dict[bool, list[float]] = {True: [], False: []}
    done: list[RolloutResult] = []
    for _ in range(repeats):
        for singly, rollouts in ways.items():
            seeds = range(BATCH_SINGLY if singly else BATCH)
            start_s = process_time()
            done = rollouts.run(seeds, ticks * scenario.dt_s)
            spent_us[singly].append((process_time() - start_s) * 1e6 / (ticks * len(seeds)))
    share = sum(outcome.decided_singly for outcome in done) / sum(outcome.ticks for outcome in done)
    return median(spent_us[True]), median(spent_us[False]), share


if __name__ == "__main__":
    typer.run(main)
