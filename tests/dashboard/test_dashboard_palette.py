from itertools import combinations

import pytest
from passafe_dashboard.palette import (
    INK,
    LINE_COLOURS,
    LINE_DASHES,
    PAPER,
    PHASE_MEANINGS,
    STATUS_STYLES,
    UNSAFE_COLOUR,
    ZERO_COLOUR,
    line_style,
)
from passafe_protocol.messages import BY_SEVERITY, FilterStatus, PlantPhase


def channels(colour: str) -> list[float]:
    return [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]


def luminance(colour: str) -> float:
    """Relative luminance as WCAG 2.2 defines it."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels(colour)]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    lighter, darker = sorted((luminance(one), luminance(other)), reverse=True)
    return (lighter + 0.05) / (darker + 0.05)


def as_deuteranope(colour: str) -> list[float]:
    """Return a colour as seen without green receptors (Viénot, Brettel & Mollon, 1999), linear RGB."""
    red, green, blue = (c**2.2 for c in channels(colour))
    mixed = 0.29275 * red + 0.70725 * green
    return [mixed, mixed, -0.02234 * red + 0.02234 * green + blue]


@pytest.mark.parametrize("colour", [*LINE_COLOURS, UNSAFE_COLOUR, ZERO_COLOUR])
def test_lines_stand_out_from_the_paper(colour: str) -> None:
    assert contrast(colour, PAPER) >= 3.0


@pytest.mark.parametrize("status", list(FilterStatus))
def test_status_text_has_contrast_on_its_colour(status: FilterStatus) -> None:
    style = STATUS_STYLES[status]
    assert contrast(style.text, style.background) >= 4.5
    assert style.text in (INK, PAPER)


def test_every_status_and_phase_has_a_meaning() -> None:
    assert list(STATUS_STYLES) == list(BY_SEVERITY)
    assert set(PHASE_MEANINGS) == set(PlantPhase)


def test_lines_of_a_chart_differ_even_without_colour() -> None:
    styles = [line_style(i) for i in range(len(LINE_COLOURS) * len(LINE_DASHES))]
    assert len(set(styles)) == len(styles)
    assert len({dash for _, dash in styles[:5]}) == 5


def test_the_first_lines_differ_for_who_sees_no_green() -> None:
    for one, other in combinations(LINE_COLOURS[:3], 2):
        distance = sum((a - b) ** 2 for a, b in zip(as_deuteranope(one), as_deuteranope(other), strict=True))
        assert distance**0.5 > 0.1
