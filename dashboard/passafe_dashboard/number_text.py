"""Write numbers as text, for reports and descriptions of pictures."""

from typing import Final

MINUS: Final = "−"


def number(value: object, digits: int = 4) -> str:
    """Return a number as text; ``unknown`` for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return "unknown"
    return signed(f"{value:.{digits}g}")


def signed(text: str) -> str:
    """Return text with minus signs in the place of hyphens."""
    return text.replace("-", MINUS)
