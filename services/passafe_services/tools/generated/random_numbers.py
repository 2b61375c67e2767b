"""Random numbers in the distributions that designs are drawn from."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two positive ones whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def chance(rng: np.random.Generator, probability: float) -> bool:
    """Return whether something with a given probability happens."""
    return bool(rng.random() < probability)


def one_of(rng: np.random.Generator, choices: Sequence[T]) -> T:
    """Return one of some choices, each as likely as the others."""
    return choices[int(rng.integers(len(choices)))]


def some_of(rng: np.random.Generator, choices: Sequence[T], most: int) -> tuple[T, ...]:
    """Return between one and ``most`` of some choices, in their order."""
    count = int(rng.integers(1, min(most, len(choices)) + 1))
    return tuple(choices[i] for i in sorted(rng.permutation(len(choices))[:count].tolist()))
