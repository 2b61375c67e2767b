"""One loop of a design: its start, its operator, and the inputs that do not arrive."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from passafe.numerics.workspace import Array
from passafe_services.tools.generated.generated_design import GeneratedDesign
from passafe_services.tools.generated.operators import OPERATORS, Operator
from passafe_services.tools.generated.protected_set import ProtectedSet
from passafe_services.tools.generated.random_numbers import chance, one_of

STREAM: Final = 0x100B
"""First part of the seed of every loop's generator."""

TICKS: Final = (50, 300)
HORIZON_S: Final = 3.0
"""Plant time that a loop would last if it had no least and no largest number of ticks, s."""

SHARE_WITH_LOSS: Final = 0.4
SHARE_OUTSIDE: Final = 0.15
SHARE_AT_THE_BOUNDARY: Final = 0.4


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class LoopPlan:
    """Everything that a loop needs beside its design and filter.

    Attributes:
        x: Start, shape (n,).
        started_inside: Whether it is in the protected set.
        operator_name: Who asks for inputs.
        operator: The same.
        arrives: Whether the input of each tick reaches the plant; the one before stays in force otherwise, and never
            longer than the design's hold.
    """

    x: Array
    started_inside: bool
    operator_name: str
    operator: Operator
    arrives: NDArray[np.bool_]

    @classmethod
    def of(cls, seed: int, design: GeneratedDesign, protected: ProtectedSet) -> "LoopPlan":
        """Draw the loop of a seed."""
        rng = np.random.default_rng([STREAM, seed])
        x, started_inside = _start(rng, protected)
        name = one_of(rng, list(OPERATORS))
        least, most = TICKS
        ticks = int(np.clip(round(HORIZON_S / design.timing.dt_s), least, most))
        return cls(
            x=x,
            started_inside=started_inside,
            operator_name=name,
            operator=OPERATORS[name](rng, design),
            arrives=_arrivals(rng, design, ticks),
        )


def _start(rng: np.random.Generator, protected: ProtectedSet) -> tuple[Array, bool]:
    inside, outside = protected.draw(rng, 200)
    kind = rng.random()
    if not inside.size or (kind < SHARE_OUTSIDE and outside.size):
        return outside[:, 0], False
    if kind < SHARE_OUTSIDE + SHARE_AT_THE_BOUNDARY and outside.size:
        return protected.boundary(inside[:, 0], outside[:, 0]), True
    return inside[:, 0], True


def _arrivals(rng: np.random.Generator, design: GeneratedDesign, ticks: int) -> NDArray[np.bool_]:
    """Draw which inputs arrive: all, or bursts of losses as long as the hold covers."""
    arrives = np.ones(ticks, dtype=bool)
    most = int(design.timing.held_s / design.timing.dt_s * (1 + 1e-9)) - 1
    if most < 1 or not chance(rng, SHARE_WITH_LOSS):
        return arrives
    probability, k = rng.uniform(0.05, 0.5), 1
    while k < ticks:
        if rng.random() < probability:
            lost = int(rng.integers(1, most + 1))
            arrives[k : k + lost] = False
            k += lost
        k += 1
    return arrives
