"""Words for distances and directions, as a person at the controls reads them."""

from typing import Final

from passafe_dashboard.live.barrier_gaps import Gap

_DEGREES: Final = 57.29577951308232
TOUCHING_M: Final = 5e-4
"""Distance below which a robot is at the limit, m."""

_SCALES: Final = {"m": ((0.995, 1.0, "m"), (0.00995, 100.0, "cm"), (0.0, 1000.0, "mm"))}
"""Of a unit: from which size on, factor, and the unit that is shown."""


def distance_text(distance: float, unit: str) -> str:
    """Return the size of a distance with two digits that count and the unit that suits it: 4 cm, 1.2 m, 3.1°."""
    size = abs(distance)
    if unit == "m" and size < TOUCHING_M:
        return "0 mm"
    if unit in ("rad", "rad/s"):
        return f"{_two_digits(size * _DEGREES)}°{unit.removeprefix('rad')}"
    for least, factor, shown in _SCALES.get(unit, ()):
        if size >= least:
            return f"{_two_digits(size * factor)} {shown}"
    return f"{_two_digits(size)} {unit}".rstrip()


def is_at_limit(distance: float, unit: str) -> bool:
    """Return whether a distance is shown as 0."""
    return f"{distance_text(distance, unit)} ".startswith(("0 ", "0°"))


def age_text(age_ns: int) -> str:
    """Return an age in ms, or in s from one second on."""
    return f"{age_ns * 1e-6:.0f} ms" if age_ns < 1e9 else f"{age_ns * 1e-9:.1f} s"  # noqa: PLR2004 - one second


def _two_digits(size: float) -> str:
    """Return a number without an exponent; below a hundredth it is 0."""
    if size >= 10.0:  # noqa: PLR2004 - two digits are before the point
        return f"{size:.0f}"
    return f"{size:.1f}" if round(size, 2) >= 1.0 else f"{size:.2f}".rstrip("0").rstrip(".") or "0"


def side(gap: Gap) -> str:
    """Return on which side of the robot the barrier lies, as seen on the picture; empty without a direction."""
    right, up = gap.towards
    if gap.unit != "m" or not (right or up):
        return ""
    if abs(right) >= abs(up):
        return "on the right" if right > 0 else "on the left"
    return "above" if up > 0 else "below"


def barrier_words(gap: Gap, kind: str) -> str:
    """Return a barrier as a person calls it: the wall on the left, “pillar” above, the speed limit."""
    words = {
        "half-plane": "the wall",
        "keep-apart": "the other robot",
        "speed-limit": "the speed limit",
    }
    return f"{words.get(kind, f'“{gap.name}”')} {side(gap)}".rstrip()
