"""Slice of the state space: two coordinates vary over a grid of cells, the others are fixed."""

from dataclasses import dataclass
from math import isfinite
from typing import Final

import numpy as np

from passafe.numerics.workspace import Array
from passafe_services.tools.feasibility.errors import FeasibilityError

MOST_CELLS: Final = 1000
"""Largest number of cells along one axis: a million states take minutes and much memory."""


@dataclass(frozen=True, kw_only=True, slots=True)
class GridCoordinate:
    """Varied coordinate of the state.

    Attributes:
        index: Index of the coordinate, from 0.
        low: Lower end, in the unit of the coordinate.
        high: Upper end, in the unit of the coordinate.
    """

    index: int
    low: float
    high: float

    def __post_init__(self) -> None:
        """Refuse an empty interval."""
        if not (isfinite(self.low) and isfinite(self.high) and self.low < self.high):
            got = f"{self.low:g} to {self.high:g}"
            raise FeasibilityError(f"range of x{self.index}", got, "two finite numbers, the smaller one first")


@dataclass(frozen=True, kw_only=True, slots=True)
class Grid:
    """Grid of cells, equally many along both axes; each stands for the state at its centre.

    Attributes:
        across: Coordinate that varies from left to right.
        up: Coordinate that varies from bottom to top.
        fixed: State that fixes the other coordinates, n numbers; its two varied coordinates are ignored.
        cells: Number of cells along each axis.
    """

    across: GridCoordinate
    up: GridCoordinate
    fixed: tuple[float, ...]
    cells: int

    def __post_init__(self) -> None:
        """Refuse axes that are not two different coordinates of the state."""
        for axis in (self.across, self.up):
            if not 0 <= axis.index < len(self.fixed):
                allowed = f"x0 to x{len(self.fixed) - 1}, the states of the model"
                raise FeasibilityError("axes", f"x{axis.index}", allowed)
        if self.across.index == self.up.index:
            raise FeasibilityError("axes", f"x{self.up.index} twice", "two different coordinates")
        if not 1 <= self.cells <= MOST_CELLS:
            raise FeasibilityError("cells", self.cells, f"1 to {MOST_CELLS} along each axis")

    def edges(self, axis: GridCoordinate) -> Array:
        """Return the edges of the cells along an axis, shape (cells + 1,)."""
        return np.linspace(axis.low, axis.high, self.cells + 1)

    def states(self) -> Array:
        """Return the state of every cell, row by row from the lowest, shape (n, cells²)."""
        middles = [(edges[1:] + edges[:-1]) / 2 for edges in map(self.edges, (self.across, self.up))]
        across, up = np.meshgrid(*middles)
        states = np.repeat(np.array(self.fixed, dtype=np.float64)[:, None], self.cells**2, axis=1)
        states[self.across.index], states[self.up.index] = across.ravel(), up.ravel()
        return states
