"""Columns of a table: name, kind and unit."""

from typing import Final, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Kind: TypeAlias = Literal["float", "int", "uint", "bool", "text"]

Array: TypeAlias = (
    NDArray[np.float64] | NDArray[np.int64] | NDArray[np.uint64] | NDArray[np.bool_] | NDArray[np.object_]
)
"""Values of one column, shape (rows,)."""

DTYPES: Final[dict[Kind, type]] = {
    "float": np.float64,
    "int": np.int64,
    "uint": np.uint64,
    "bool": np.bool_,
    "text": np.object_,
}
"""NumPy type of each kind; text is kept as Python strings."""

SUFFIX_UNITS: Final = {"ns": "ns", "us": "µs", "s": "s", "hz": "Hz", "j": "J"}
"""Unit that the last part of a column's name carries."""


class Column(NamedTuple):
    """One column.

    Attributes:
        name: Its name: lower-case letters, digits and underscores, so that it is an attribute in pandas, a field in
            protobuf and a plain word in a message path.
        kind: Kind of its values.
        unit: Unit, empty for what has none or where it is not known.
    """

    name: str
    kind: Kind
    unit: str = ""

    @property
    def heading(self) -> str:
        """Name as the head of a CSV column: with the unit in brackets where the name does not carry it."""
        carried = SUFFIX_UNITS.get(self.name.rpartition("_")[2], "") == self.unit
        return self.name if carried else f"{self.name} [{self.unit}]"


def unit_in(name: str) -> str:
    """Return the unit that a name carries, such as ns of ``sent_ns``; empty if it carries none."""
    stem, separator, suffix = name.rpartition("_")
    return SUFFIX_UNITS.get(suffix, "") if stem and separator else ""
