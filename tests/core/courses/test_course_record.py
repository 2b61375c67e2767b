"""The record of a course: what a summary leaves out is what makes no difference."""

import numpy as np
import pytest

from passafe.courses.course import CHUNK, Course
from passafe.courses.course_record import SMALL_ERROR, ChunkSummary, CourseRecord
from passafe.numerics.workspace import Array

CHUNKS = 6


def chunk(*, h: float = 1.0, bound: float = 0.5, slope: float = 1.0, error: float = 0.0, known: float = 1.0) -> Array:
    return np.tile(np.array([[h], [bound], [slope], [error], [known]]), (1, CHUNK))


def summary(seen: Array) -> ChunkSummary[float]:
    """Return it as CasADi's functions do: a minimum passes over what is no number."""
    estimates, bounds, _, _, known = np.where(np.isnan(seen), np.inf, seen).min(axis=1).tolist()
    error, total = float(seen[3].cumsum()[-1]), sum(seen.ravel().tolist())
    return ChunkSummary(lowest=estimates, bound=bounds, error=error, known=known, total=total)


def course(*chunks: Array) -> Course:
    record = CourseRecord()
    for seen in chunks:
        record.add(seen, summary(seen))
    return record.course(rests=False)


def looked_at(*chunks: Array) -> Course:
    """Return the same with every single period looked at."""
    record = CourseRecord()
    for seen in chunks:
        record.add(seen, ChunkSummary(*([np.nan] * len(ChunkSummary.names()))))
    return record.course(rests=False)


@pytest.mark.parametrize("seed", range(300))
def test_summary_leaves_out_nothing_that_matters(seed: int) -> None:
    rng = np.random.default_rng(seed)
    chunks = []
    for _ in range(CHUNKS):
        seen = chunk()
        seen[0] = rng.choice([1.0, 0.3, -0.2]) + rng.choice([0.0, 0.1]) * rng.normal(size=CHUNK)
        seen[1] = seen[0] - rng.uniform(0, 0.3, CHUNK)
        seen[3] = rng.choice([0.0, 1e-9, 1e-7, 1e-4]) * rng.uniform(size=CHUNK)
        if rng.random() < 0.2:
            seen[rng.choice([0, 1, 4]), rng.integers(CHUNK)] = rng.choice([np.nan, np.inf, -np.inf, 0.0])
        chunks.append(seen)

    assert course(*chunks) == looked_at(*chunks)


def test_only_what_is_new_makes_a_course_worse() -> None:
    record, first, same, lower = CourseRecord(), chunk(), chunk(), chunk(h=-1.0, bound=-2.0)

    assert [record.add(seen, summary(seen)) for seen in (first, same, lower, lower)] == [True, False, True, False]
    assert not record.is_kept


def test_a_loss_is_where_h_first_falls_below_zero() -> None:
    falls = chunk()
    falls[0, 5:], falls[0, 9] = -0.1, -0.4
    found = course(chunk(), falls, chunk(h=-0.2), chunk(h=-5.0))

    assert (found.kept_periods, found.lowest, found.lowest_at) == (CHUNK + 5, -5.0, 3 * CHUNK)
    assert found.soon == -0.4  # in the chunk of the loss; the one after begins no more than CHUNK periods later
    assert found.proven == 0.5


def test_errors_that_add_up_lower_h_by_their_slope() -> None:
    error = SMALL_ERROR / CHUNK
    found = course(*[chunk(h=1.0, bound=0.5, slope=2.0, error=error)] * 3)

    assert found.lowest == pytest.approx(1 - 2 * 2 * SMALL_ERROR, abs=1e-12)
    assert found.proven == pytest.approx(0.5 - 2 * 2 * SMALL_ERROR, abs=1e-12)
    assert found.is_proven


@pytest.mark.parametrize("seen", [chunk(known=0.0), chunk(error=1e-3), chunk(h=np.nan, bound=np.nan)])
def test_what_is_not_known_is_not_proven(seen: Array) -> None:
    record = CourseRecord()
    record.add(chunk(), summary(chunk()))
    record.add(seen, summary(seen))

    assert not record.is_kept
