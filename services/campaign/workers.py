"""Rollouts in worker processes, one derived filter in each."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

from services.campaign.rollout import Outcome, Rollouts
from services.scenarios.schema import Scenario

CHUNK = 4
"""Rollouts that a worker takes at a time."""

_of_this_process: list[Rollouts] = []


def outcomes(scenario: Scenario, seeds: Sequence[int], duration_s: float, workers: int) -> Iterator[Outcome]:
    """Yield the outcome of every seed, in their order.

    Args:
        scenario: What is run.
        seeds: Each decides one rollout's start and adversary.
        duration_s: Plant time of each, s.
        workers: Processes; with one, everything happens in this process.
    """
    if workers == 1:
        rollouts = Rollouts(scenario)
        yield from (rollouts.run(seed, duration_s) for seed in seeds)
        return
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_prepare, initargs=(scenario,))
    try:
        yield from pool.map(partial(_run, duration_s=duration_s), seeds, chunksize=CHUNK)
    finally:
        pool.shutdown(cancel_futures=True)


def _prepare(scenario: Scenario) -> None:
    _of_this_process[:] = [Rollouts(scenario)]


def _run(seed: int, *, duration_s: float) -> Outcome:
    return _of_this_process[0].run(seed, duration_s)
