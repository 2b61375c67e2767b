"""Columns of a table of messages: numbers, texts, and rows with a varying number of either."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

Numbers: TypeAlias = NDArray[Any]
Places: TypeAlias = NDArray[np.intp]
Counts: TypeAlias = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Ragged:
    """Column whose rows hold a varying number of values, as a vector or a list of a message does.

    Attributes:
        values: Values of all rows, one row behind the other.
        counts: Number of values of each row, shape (N,).
    """

    values: Numbers
    counts: Counts

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def starts(self) -> Counts:
        """Place of the first value of each row, shape (N,)."""
        return np.cumsum(self.counts) - self.counts

    @property
    def row_numbers(self) -> Places:
        """Row of each value, of the shape of ``values``."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    def matrix(self, width: int) -> Numbers:
        """Return the values as shape (N, width): longer rows cut, shorter ones filled with NaN, or 0 for integers."""
        if (self.counts == width).all():
            return self.values.reshape(len(self.counts), width)
        filled = np.full((len(self), width), np.nan if self.values.dtype.kind == "f" else 0, dtype=self.values.dtype)
        within = np.arange(width) < self.counts[:, None]
        filled[within] = self.values[(self.starts[:, None] + np.arange(width))[within]]
        return filled

    def take(self, rows: Places) -> Self:
        """Return the column of these rows."""
        counts = self.counts[rows]
        if counts.size and (self.counts == self.counts[0]).all():
            table = self.values.reshape(len(self.counts), int(self.counts[0]))
            return type(self)(table[rows].reshape(-1), counts)
        return type(self)(self.values[_expanded(self.starts[rows], counts)], counts)

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the column of one part behind the other."""
        return cls(np.concatenate([part.values for part in parts]), np.concatenate([part.counts for part in parts]))


@dataclass(frozen=True, slots=True, eq=False)
class Texts:
    """Column of texts, of which few differ.

    Attributes:
        codes: Index in ``words`` of each row's text; a ``Ragged`` column for texts in a list.
        words: The texts that occur.
    """

    codes: "Numbers | Ragged"
    words: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.codes)

    def are(self, *words: str) -> NDArray[np.bool_]:
        """Return which rows have one of these texts; for texts in a list, which of its values."""
        codes = self.codes.values if isinstance(self.codes, Ragged) else self.codes
        wanted = [number for number, word in enumerate(self.words) if word in words]
        return np.isin(codes, wanted)

    def take(self, rows: Places) -> Self:
        """Return the column of these rows."""
        codes = self.codes.take(rows) if isinstance(self.codes, Ragged) else self.codes[rows]
        return type(self)(codes, self.words)

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the column of one part behind the other."""
        words = tuple(dict.fromkeys(word for part in parts for word in part.words))
        number_of = {word: number for number, word in enumerate(words)}
        codes: list[Numbers | Ragged] = []
        for part in parts:
            to_all = np.array([number_of[word] for word in part.words], dtype=np.int32)
            if isinstance(part.codes, Ragged):
                codes.append(Ragged(to_all[part.codes.values], part.codes.counts))
            else:
                codes.append(to_all[part.codes])
        return cls(joined(codes), words)


Column: TypeAlias = Numbers | Ragged | Texts


def take(column: Column, rows: Places) -> Column:
    """Return these rows of a column."""
    return column[rows] if isinstance(column, np.ndarray) else column.take(rows)


def joined(parts: Sequence[Any]) -> Any:  # noqa: ANN401 - columns of one kind give a column of that kind
    """Return one column out of columns of one kind, one behind the other."""
    if len(parts) == 1:
        return parts[0]
    return np.concatenate(parts) if isinstance(parts[0], np.ndarray) else type(parts[0]).joined(parts)


def _expanded(starts: Counts, counts: Counts) -> Places:
    """Return the places of all values of rows that begin at ``starts``."""
    ends = np.cumsum(counts)
    total = int(ends[-1]) if len(ends) else 0
    places: Places = np.arange(total) + np.repeat(starts - (ends - counts), counts)
    return places


def same_rows(first: Column, second: Column) -> NDArray[np.bool_]:
    """Return which rows of two columns of one kind and length are the same to the last bit, shape (N,)."""
    if isinstance(first, Texts) and isinstance(second, Texts):
        number_of = {word: number for number, word in enumerate(second.words)}
        to_second = np.array([number_of.get(word, -1) for word in first.words], dtype=np.int32)
        codes = first.codes
        coded = Ragged(to_second[codes.values], codes.counts) if isinstance(codes, Ragged) else to_second[codes]
        return same_rows(coded, second.codes)
    if isinstance(first, Ragged) and isinstance(second, Ragged):
        same: NDArray[np.bool_] = first.counts == second.counts
        (rows,) = np.nonzero(same)
        one, other = (first, second) if rows.size == same.size else (first.take(rows), second.take(rows))
        equal = _bits(one.values) == _bits(other.values)
        same[rows[one.row_numbers[~equal]]] = False
        return same
    if isinstance(first, np.ndarray) and isinstance(second, np.ndarray):
        return np.asarray(_bits(first) == _bits(second))
    raise TypeError(f"columns: got {type(first).__name__} and {type(second).__name__}, allowed two of one kind")


def _bits(values: Numbers) -> Numbers:
    """Return numbers as integers: they tell 0.0 from −0.0, and know a NaN again."""
    return values.view(np.int64) if values.dtype == np.float64 else values
