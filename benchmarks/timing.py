"""Times calls and runs measurements side by side."""

import gc
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import perf_counter_ns
from typing import Any, TypeVar

import numpy as np

T = TypeVar("T")
Times = np.ndarray[Any, np.dtype[np.float64]]


def in_turn(measures: Sequence[Callable[[], T]], rounds: int) -> list[list[T]]:
    """Return the results of every measure, one for each round.

    Every round runs all measures and begins with another one, so that a drift of the machine hits all alike: ratios
    within a round mean something on a machine whose load changes, while the times themselves do not.
    """
    results: list[list[T]] = [[] for _ in measures]
    for turn in range(rounds):
        for place in range(len(measures)):
            which = (turn + place) % len(measures)
            gc.collect()
            results[which].append(measures[which]())
    return results


def call_times_us(call: Callable[..., object], requests: Sequence[Sequence[Any]]) -> Times:
    """Return the wall-clock time of a call with each of some requests, µs."""
    times = np.zeros(len(requests))
    with without_collector():
        for k, request in enumerate(requests):
            begin = perf_counter_ns()
            call(*request)
            times[k] = (perf_counter_ns() - begin) / 1e3
    return times


@contextmanager
def without_collector() -> Iterator[None]:
    """Keep the garbage collector from running."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
