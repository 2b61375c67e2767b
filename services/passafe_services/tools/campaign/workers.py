"""Batches of rollouts in worker processes, one derived filter in each."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from typing import Final

from threadpoolctl import threadpool_limits

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.rollout import Rollouts
from passafe_services.tools.campaign.rollout_result import RolloutResult

BATCH: Final = 1000
"""Rollouts in lock step, at most: with more an operation costs each of them hardly less, and outcomes come later."""

BATCH_SINGLY: Final = 16
"""The same where the filter takes every decision one by one."""

_of_this_process: list[Rollouts] = []


def outcomes(
    scenario: Scenario, seeds: Sequence[int], duration_s: float, workers: int, *, singly: bool = False
) -> Iterator[list[RolloutResult]]:
    """Yield the outcomes of every seed, batch by batch as they are done.

    Args:
        scenario: What is run.
        seeds: Each decides one rollout's start and adversary.
        duration_s: Plant time of each, s.
        workers: Processes; with one, everything happens in this process.
        singly: Whether the filter takes every decision one by one.
    """
    batches = _batches(seeds, workers, BATCH_SINGLY if singly else BATCH)
    if workers == 1:
        with threadpool_limits(1):
            rollouts = Rollouts(scenario, singly=singly)
            yield from (rollouts.run(batch, duration_s) for batch in batches)
        return
    pool = ProcessPoolExecutor(workers, get_context("spawn"), initializer=_prepare, initargs=(scenario, singly))
    try:
        running = [pool.submit(_run, batch, duration_s) for batch in batches]
        yield from (done.result() for done in as_completed(running))
    finally:
        pool.shutdown(cancel_futures=True)


def _batches(seeds: Sequence[int], workers: int, most: int) -> list[Sequence[int]]:
    """Return the seeds in batches of nearly the same size, as many for one worker as for another if possible."""
    count = max(-(-len(seeds) // most), min(workers, len(seeds)))
    if count > workers:
        count = -(-count // workers) * workers
    edges = [len(seeds) * i // max(count, 1) for i in range(count + 1)]
    return [seeds[edges[i] : edges[i + 1]] for i in range(count)]


def _prepare(scenario: Scenario, singly: bool) -> None:
    threadpool_limits(1)  # as many processes as cores: threads of theirs would only wait for one another
    _of_this_process[:] = [Rollouts(scenario, singly=singly)]


def _run(seeds: Sequence[int], duration_s: float) -> list[RolloutResult]:
    return _of_this_process[0].run(seeds, duration_s)
