"""Shape in which a robot is drawn: points, links between them, an outline that turns with a heading."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import casadi as ca

from passafe.errors import DesignError, ShapeError
from passafe.expressions import as_column

MOST_CORNERS: Final = 64
"""Corners of an outline, links and points of a drawing: what a page draws thirty times a second."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Drawing:
    """Points of a robot as functions of its state, and the lines between them.

    Attributes:
        points: Places of the points one after the other, expression of x, shape (d·k, 1), m, in the world's frame.
        dimensions: d, 2 in the plane and 3 in space.
        links: Pairs of points, counted from 0, that a line joins.
        outline: Corners of a polygon in the frame of the robot's body, m, forward first and left second; it is drawn
            at the first point, turned by the heading.
        heading: Angle from the world's first axis to the body's, counter-clockwise, rad, a scalar expression of x;
            0 if it is not given.
        radii: Radius of each point's ball, m; empty where points are dots.
    """

    points: ca.SX
    dimensions: int = 2
    links: tuple[tuple[int, int], ...] = ()
    outline: tuple[tuple[float, float], ...] = ()
    heading: ca.SX = field(default_factory=lambda: ca.SX(0))
    radii: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Refuse shapes and numbers of points that do not fit."""
        object.__setattr__(self, "points", as_column("drawing points", self.points))
        object.__setattr__(self, "heading", as_column("drawing heading", self.heading))
        if self.dimensions not in (2, 3):
            raise DesignError("drawing dimensions", self.dimensions, "2 or 3")
        count, rest = divmod(int(self.points.numel()), self.dimensions)
        if rest or not 1 <= count <= MOST_CORNERS:
            allowed = f"{self.dimensions} rows for each of 1 to {MOST_CORNERS} points"
            raise ShapeError("drawing points", f"shape {self.points.shape}", allowed)
        if self.heading.shape != (1, 1):
            raise ShapeError("drawing heading", f"shape {self.heading.shape}", "shape (1, 1)")
        if any(not (len(pair) == 2 and all(0 <= end < count for end in pair)) for pair in self.links):  # noqa: PLR2004 - a pair
            raise DesignError("drawing links", self.links, f"pairs of points from 0 to {count - 1}")
        if self.radii and len(self.radii) != count:
            raise DesignError("drawing radii", f"{len(self.radii)} numbers", f"one for each of {count} points, or none")
        _require_few("links", self.links)
        _require_few("outline", self.outline)

    @property
    def count(self) -> int:
        """Return the number of points."""
        return int(self.points.numel()) // self.dimensions


def _require_few(part: str, items: Sequence[object]) -> None:
    if len(items) > MOST_CORNERS:
        raise DesignError(f"drawing {part}", f"{len(items)} entries", f"at most {MOST_CORNERS}")
