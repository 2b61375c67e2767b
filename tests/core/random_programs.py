"""Random quadratic programs min ½‖z‖² subject to G z ≥ d with one or two rows of unit length, easy and nasty ones."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

KINDS = (
    "generic",
    "parallel",
    "antiparallel",
    "nearly parallel",
    "nearly antiparallel",
    "duplicated",
    "without gradient",
)


def random_programs(
    seed: int, count: int, size: int, kinds: tuple[str, ...] = KINDS
) -> Iterator[tuple[str, Array, Array]]:
    """Yield (kind, G, d) with two rows of length ``size``; bounds range from 1e-6 to 100 either way, zero included."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        kind = kinds[k % len(kinds)]
        first = unit(rng.normal(size=size))
        second = second_row(rng, kind, first)
        d = rng.normal(size=2) * 10 ** rng.uniform(-6, 2, 2)
        if rng.uniform() < 0.1:
            d[rng.integers(2)] = 0.0
        if kind == "duplicated":
            d[1] = d[0]
        yield kind, np.asfortranarray([first, second]), d


def second_row(rng: np.random.Generator, kind: str, first: Array) -> Array:
    """Return a row that stands to the first one as the kind says."""
    tilt = rng.normal(size=first.size) * 10 ** rng.uniform(-12, -1)
    if kind in {"parallel", "duplicated"}:
        return first.copy()
    if kind == "antiparallel":
        return -first
    if kind == "nearly parallel":
        return unit(first + tilt)
    if kind == "nearly antiparallel":
        return unit(tilt - first)
    if kind == "without gradient":
        return np.zeros(first.size)
    return unit(rng.normal(size=first.size))


def unit(vector: Array) -> Array:
    """Return the vector at length 1."""
    return np.asarray(vector / np.linalg.norm(vector))
