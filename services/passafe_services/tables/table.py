"""One table of a log as NumPy arrays."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from passafe.errors import NotAllowedError
from passafe_services.suggestion import suggestion
from passafe_services.tables.columns import Array

if TYPE_CHECKING:
    import pandas as pd


class ColumnNameError(NotAllowedError):
    """A column that a table does not have; the field is the table's name."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Table:
    """Messages of one topic: a row for each, in order of log time.

    ``table["tank_j"]`` is a NumPy array, ``table.pandas()`` the whole as a data frame.

    Attributes:
        name: Name of the topic.
        rows: Number of rows.
        columns: Values of each column by name, shape (rows,).
        units: Unit of each column that has one.
    """

    name: str
    rows: int
    columns: Mapping[str, Array] = field(repr=False)
    units: Mapping[str, str] = field(repr=False)

    def __len__(self) -> int:
        return self.rows

    def __getitem__(self, column: str) -> Array:
        if column not in self.columns:
            raise self._unknown(column)
        return self.columns[column]

    def matrix(self, vector: str) -> NDArray[np.float64]:
        """Return the numbers of a vector, such as ``x`` for ``x_1``, ``x_2``, …, shape (rows, length).

        Args:
            vector: Name of the columns without their numbers.

        Raises:
            ColumnNameError: The table has no such columns.
        """
        found = [
            name for name in self.columns if name.rpartition("_")[0] == vector and name.rpartition("_")[2].isdigit()
        ]
        if not found:
            raise self._unknown(f"{vector}_1")
        return np.stack([np.asarray(self.columns[name], dtype=np.float64) for name in found], axis=1)

    def pandas(self) -> "pd.DataFrame":
        """Return the table as a pandas data frame, whose ``attrs["units"]`` are the units."""
        import pandas as pd  # noqa: PLC0415 - only where it is wanted: NumPy is enough for all else

        frame = pd.DataFrame(dict(self.columns))
        frame.attrs["units"] = dict(self.units)
        return frame

    def _unknown(self, column: str) -> ColumnNameError:
        allowed = f"one of its {len(self.columns)} columns{suggestion(column, self.columns)}"
        return ColumnNameError(f"column of {self.name}", column, allowed)
