"""Rules of enclosure: for every elementary operation that has a derivative, the ball of all that it can be."""

from collections.abc import Callable, Mapping
from typing import Final

from passafe.enclosures.rules import arithmetic, kinks, monotone, planar, powers, waves
from passafe.enclosures.rules.ball import Ball

RULES: Final[Mapping[int, Callable[..., Ball]]] = {
    **arithmetic.RULES,
    **powers.RULES,
    **monotone.RULES,
    **waves.RULES,
    **planar.RULES,
    **kinks.RULES,
}
"""By CasADi's number of the operation: from the balls of its arguments to that of its values."""
