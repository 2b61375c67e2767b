"""Define the colours of dashboard and pictures: safe for colour-blind eyes, never the only carrier of a meaning.

The hues are those of Okabe & Ito (2008), some darkened so that lines stand out from white by 3 : 1 or more
and text from its background by 4.5 : 1 or more (the contrasts that WCAG 2.2 asks for; a test computes them).
"""

from typing import Final, NamedTuple

from passafe_protocol.messages import FilterStatus, PlantPhase

LINE_COLOURS: Final = ("#0072B2", "#C44E00", "#00785A", "#882255", "#4D4D4D")
"""Of the first line of a chart, the second, …; used with ``LINE_DASHES``, so that grey print works too."""

LINE_DASHES: Final = ("solid", "dashed", "dotdash", "dotted", "dashdot")
ZERO_COLOUR: Final = "#222222"
TRAIL_COLOUR: Final = LINE_COLOURS[0]
UNSAFE_COLOUR: Final = "#D55E00"
"""Fill, drawn faint, and outline of the regions to keep out of."""

INK: Final = "#1A1A1A"
PAPER: Final = "#FFFFFF"


class StatusStyle(NamedTuple):
    """Meaning of one filter status, its background and the text colour on it."""

    meaning: str
    background: str
    text: str


STATUS_STYLES: Final[dict[FilterStatus, StatusStyle]] = {  # in the order of severity
    FilterStatus.PASSED: StatusStyle("the operator's input goes through unchanged", "#00785A", PAPER),
    FilterStatus.MODIFIED: StatusStyle("the filter changes the input; every row is kept", "#0072B2", PAPER),
    FilterStatus.RELAXED: StatusStyle("the passivity row is relaxed by the slack", "#E69F00", INK),
    FilterStatus.BACKUP: StatusStyle(
        "the backup law's course keeps the barriers, whatever the rows say", "#56B4E9", INK
    ),
    FilterStatus.STOPPED: StatusStyle("an emergency stop is latched at the plant; nothing is sent", "#8B0000", PAPER),
    FilterStatus.STALE: StatusStyle("command or plant state is too old; fallback in force", "#8A8A8A", INK),
    FilterStatus.AT_SAMPLES: StatusStyle(
        "rows kept now, perhaps not between samples; fallback in force", "#7A5C00", PAPER
    ),
    FilterStatus.UNCERTIFIED: StatusStyle("the solver's answer was refused; fallback in force", "#882255", PAPER),
    FilterStatus.INFEASIBLE: StatusStyle("hard rows conflict; fallback in force", "#B03A00", PAPER),
}

PHASE_MEANINGS: Final[dict[PlantPhase, str]] = {
    PlantPhase.WAITING: "no input has taken effect yet",
    PlantPhase.RUNNING: "an input of the filter is in force",
    PlantPhase.HOLDING: "the next input is missing; the last one is held",
    PlantPhase.FAIL_SAFE: "the plant's own fail-safe law is in force",
}


PHASE_STYLES: Final[dict[PlantPhase, str]] = {
    PlantPhase.WAITING: "#8A8A8A",
    PlantPhase.RUNNING: "#00785A",
    PlantPhase.HOLDING: "#E69F00",
    PlantPhase.FAIL_SAFE: "#B03A00",
}
"""Colour of each phase of the plant in a band over time."""


def line_style(index: int) -> tuple[str, str]:
    """Return colour and dash of line number ``index``; both repeat, out of step, so that pairs last longer."""
    return (
        LINE_COLOURS[index % len(LINE_COLOURS)],
        LINE_DASHES[(index + index // len(LINE_COLOURS)) % len(LINE_DASHES)],
    )
