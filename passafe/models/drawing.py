"""Shape in which a robot is drawn: points, links between them, an outline that turns with a heading."""

from dataclasses import dataclass, field
from math import isfinite
from typing import Final

import casadi as ca

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described, is_one_number, members, numbers
from passafe.arguments.ranges import require_not_negative
from passafe.errors import DesignError, ShapeError

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
        if isinstance(self.dimensions, bool) or not is_one_number(self.dimensions) or self.dimensions not in (2, 3):
            raise DesignError("drawing dimensions", described(self.dimensions), "2 or 3")
        object.__setattr__(self, "dimensions", int(self.dimensions))
        count, rest = divmod(int(self.points.numel()), self.dimensions)
        if rest or not 1 <= count <= MOST_CORNERS:
            allowed = f"{self.dimensions} rows for each of 1 to {MOST_CORNERS} points"
            raise ShapeError("drawing points", f"shape {self.points.shape}", allowed)
        if self.heading.shape != (1, 1):
            raise ShapeError("drawing heading", f"shape {self.heading.shape}", "shape (1, 1)")
        self._take_links(count)
        outline = _pairs("outline", self.outline, "pairs of finite numbers, the corners")
        object.__setattr__(self, "outline", outline)
        radii = numbers("drawing radii", self.radii)
        if radii and len(radii) != count:
            raise DesignError("drawing radii", f"{len(radii)} numbers", f"one for each of {count} points, or none")
        for radius in radii:
            require_not_negative("drawing radii", radius, "m")
        object.__setattr__(self, "radii", radii)

    def _take_links(self, count: int) -> None:
        allowed = f"pairs of points from 0 to {count - 1}"
        ends = _pairs("links", self.links, allowed)
        if any(end not in range(count) for pair in ends for end in pair):
            raise DesignError("drawing links", described(self.links), allowed)
        object.__setattr__(self, "links", tuple((int(one), int(other)) for one, other in ends))

    @property
    def count(self) -> int:
        """Return the number of points."""
        return int(self.points.numel()) // self.dimensions


def _pairs(part: str, value: object, allowed: str) -> tuple[tuple[float, float], ...]:
    """Return pairs of finite numbers, not too many of them."""
    found = members(value)
    if found is None:
        raise DesignError(f"drawing {part}", described(value), allowed)
    if len(found) > MOST_CORNERS:
        raise DesignError(f"drawing {part}", f"{len(found)} entries", f"at most {MOST_CORNERS}")
    pairs = []
    for entry in found:
        pair = numbers(f"drawing {part}", entry, allowed)
        if len(pair) != 2 or not all(map(isfinite, pair)):  # noqa: PLR2004 - a pair
            raise DesignError(f"drawing {part}", described(entry), allowed)
        pairs.append((pair[0], pair[1]))
    return tuple(pairs)
