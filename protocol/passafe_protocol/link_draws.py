"""Random draws of a link's effects; an effect that is disabled draws nothing."""

from collections.abc import Callable


def chance(draw: Callable[[], float], probability: float) -> Callable[[], bool]:
    """Return a function that draws an event of this probability: one draw per call, none for probability zero."""
    return (lambda: draw() < probability) if probability else _never


def corruption(draw: Callable[[], float], probability: float) -> Callable[[], float | None]:
    """Return a function that draws the position of a flipped bit in [0, 1) or ``None``; two draws, none if disabled."""
    if not probability:
        return _no_corruption

    def position() -> float | None:
        corrupted, at = draw() < probability, draw()
        return at if corrupted else None

    return position


def zero() -> float:
    """Return 0.0 without a draw."""
    return 0.0


def _never() -> bool:
    return False


def _no_corruption() -> float | None:
    return None
