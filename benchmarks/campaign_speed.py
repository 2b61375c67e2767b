"""Times a tick of an adversarial campaign, decided in batches and by the scalar filter.

``python benchmarks/campaign_speed.py``. CPU time of one process, filter, plant, adversaries and h between samples
included; both take turns. The share is that of ticks of a batch which the scalar filter had to decide.
"""

from functools import partial
from time import process_time
from typing import Annotated

import typer
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.tools.campaign.campaign_job import BATCH, BATCH_SCALAR
from passafe_services.tools.campaign.rollout import Rollouts
from passafe_services.tools.campaign.rollout_result import RolloutResult
from report import AsJson, Ratio, Report, Smallest, spread
from threadpoolctl import threadpool_limits
from timing import in_turn

AGREEMENT = 1e-6
"""Largest difference between the lowest h of a rollout and that of the same one decided in a batch."""


def main(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Shipped scenarios; all of them if not given.")] = None,
    ticks: Annotated[int, typer.Option(min=1, help="Ticks of every rollout.")] = 500,
    rounds: Annotated[int, typer.Option(min=1, help="Rounds.")] = 3,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Measure µs a tick of every scenario."""
    scalar, batch = BATCH_SCALAR, BATCH
    names = scenarios or shipped_scenarios()
    if smallest:
        ticks, rounds, scalar, batch, names = 5, 1, 2, 10, names[:1]
    report = Report(
        title=f"Campaign, {ticks} ticks, {rounds} rounds",
        columns=("scenario", "scalar, µs a tick", f"batch of {batch}, µs a tick", "decided by the scalar filter"),
    )
    with threadpool_limits(1):
        for name in names:
            report.rows.append(measure(name, ticks, rounds, scalar, batch, report))
    report.finish(as_json=as_json)


def measure(name: str, ticks: int, rounds: int, scalar: int, batch: int, report: Report) -> tuple[str, ...]:
    """Return the table's row of one scenario; report its ratio, and results that differ between the two."""
    scenario = load_scenario(name)
    rollouts = {is_scalar: Rollouts(scenario, scalar=is_scalar) for is_scalar in (True, False)}
    found: dict[bool, list[RolloutResult]] = {}

    def tick_us(*, is_scalar: bool) -> float:
        seeds = range(scalar if is_scalar else batch)
        start_s = process_time()
        found[is_scalar] = rollouts[is_scalar].run(seeds, ticks * scenario.dt_s)
        return (process_time() - start_s) * 1e6 / (ticks * len(seeds))

    scalar_us, batch_us = in_turn([partial(tick_us, is_scalar=each) for each in (True, False)], rounds)
    for alone, batched in zip(found[True], found[False], strict=False):  # a batch has more rollouts
        if not abs(alone.h_min - batched.h_min) <= AGREEMENT:
            report.failures.append(f"{name}: lowest h of a rollout: got {batched.h_min}, allowed {alone.h_min}")
    report.ratios.append(Ratio.of_rounds(f"{name}: scalar", scalar_us, "batch", batch_us))
    share = sum(result.decided_scalar for result in found[False]) / sum(result.ticks for result in found[False])
    return name, spread(scalar_us), spread(batch_us, 2), f"{share:.2%}"


if __name__ == "__main__":
    typer.run(main)
