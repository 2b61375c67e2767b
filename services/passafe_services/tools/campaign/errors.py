"""Errors of campaigns; the tree of all errors is in ``passafe.errors``."""

from collections.abc import Sequence

from passafe.errors import NotAllowedError


class NoSafeStartError(NotAllowedError):
    """A box of starts without a safe one."""

    def __init__(self, scenario: str, low: Sequence[float], high: Sequence[float], draws: int) -> None:
        super().__init__(
            "plant.start_low, plant.start_high",
            f"{tuple(low)} to {tuple(high)}, where {draws} draws found no state that {scenario}'s rows protect",
            "a box with such states",
        )
