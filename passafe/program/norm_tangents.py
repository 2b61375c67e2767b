"""The tangents that stand in the program for the limits of norms: where they lie, and how many are in use."""

from passafe.limits import Limits
from passafe.numerics.fixed_order import length
from passafe.numerics.workspace import Array
from passafe.symbolic.whole_program import norm_asked, tangents_of


class TangentsOfNorm:
    """Tangents of one norm's limit; each is put where an answer was beyond it.

    Attributes:
        used: Number of those in use.
    """

    def __init__(self, axes: tuple[int, ...], asked: float, first: int, count: int) -> None:
        """Hold their places.

        Args:
            axes: The norm's.
            asked: Length that is allowed.
            first: Place of the first among the tangents of all norms.
            count: How many there are.
        """
        self._axes, self._asked, self._first, self._count = list(axes), asked, first, count
        self.used = 0

    def cut(self, cuts: Array, u: Array) -> bool:
        """Put a tangent where an input is beyond the norm's limit; return whether one was needed, and left.

        Args:
            cuts: Directions of all norms' tangents, shape (tangents, m).
            u: The input, shape (m,).
        """
        part = u[self._axes]
        size = length(part)
        if self.used == self._count or size <= self._asked:
            return False
        cuts[self._first + self.used] = 0.0
        cuts[self._first + self.used, self._axes] = part / size
        self.used += 1
        return True


def norm_tangents(limits: Limits) -> tuple[TangentsOfNorm, ...]:
    """Return the tangents of all norms, one norm after the other."""
    found: list[TangentsOfNorm] = []
    first = 0
    for norm in limits.norms:
        found.append(TangentsOfNorm(norm.axes, norm_asked(norm), first, tangents_of(norm)))
        first += tangents_of(norm)
    return tuple(found)
