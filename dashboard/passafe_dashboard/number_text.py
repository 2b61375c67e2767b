"""Write numbers as text, for reports and descriptions of pictures."""

from typing import Final

MINUS: Final = "−"
SUPERSCRIPTS: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: object, digits: int = 4) -> str:
    """Return a number as text, a very large or small one with a power of ten; ``unknown`` for anything else."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return "unknown"
    mantissa, _, exponent = f"{value:.{digits}g}".partition("e")
    return signed(mantissa) + (f"·10{str(int(exponent)).translate(SUPERSCRIPTS)}" if exponent else "")


def signed(text: str) -> str:
    """Return text with minus signs in the place of hyphens."""
    return text.replace("-", MINUS)
