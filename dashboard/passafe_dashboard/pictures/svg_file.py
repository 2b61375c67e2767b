"""Draw with matplotlib and write SVG text that is the same to the last byte for the same data."""

from collections.abc import Callable, Sequence
from io import StringIO
from typing import Any, Final
from xml.sax.saxutils import escape

from matplotlib import style
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from passafe_dashboard.palette import INK, PAPER

POINTS_PER_INCH: Final = 72.0
GRID_COLOUR: Final = "#E0E0E0"

STYLE: Final[dict[str, Any]] = {
    "axes.axisbelow": True,
    "axes.edgecolor": INK,
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.xmargin": 0.0,
    "figure.facecolor": PAPER,
    "figure.constrained_layout.h_pad": 0.08,
    "figure.constrained_layout.w_pad": 0.1,
    "font.size": 11.0,
    "grid.color": GRID_COLOUR,
    "grid.linewidth": 0.8,
    "legend.fontsize": 10.0,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "lines.linewidth": 1.8,
    "svg.fonttype": "none",  # text stays text: small, searchable, read aloud
    "svg.hashsalt": "passafe",  # names of clip paths do not change from run to run
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
}
"""Settings beside matplotlib's own defaults; those of the user have no effect."""

NO_METADATA: Final = dict.fromkeys(("Creator", "Date", "Format", "Type"))

DASHES: Final[dict[str, Any]] = {
    "solid": "solid",
    "dashed": (0, (5, 2)),
    "dotdash": (0, (1, 1.5, 4, 1.5)),
    "dotted": (0, (1, 1.5)),
    "dashdot": (0, (7, 1.5, 1, 1.5, 1, 1.5)),
}
"""Dashes of the palette in multiples of the line's width."""


def svg_text(draw: Callable[[Figure], None], *, width: float, height: float, title: str, description: str) -> str:
    """Return one SVG file.

    Args:
        draw: Draws into an empty figure.
        width: Width of the picture, points.
        height: Its height, points.
        title: Short title for screen readers.
        description: Its content in words, likewise.
    """
    buffer = StringIO()
    with style.context(["default", STYLE]):
        figure = Figure(figsize=(width / POINTS_PER_INCH, height / POINTS_PER_INCH), layout="constrained")
        draw(figure)
        figure.savefig(buffer, format="svg", metadata=NO_METADATA)
    _, _, element = buffer.getvalue().partition("<svg ")  # without a reference to a document type elsewhere
    attributes, _, content = element.partition(">")
    words = f"<title>{escape(title)}</title><desc>{escape(description)}</desc>"
    return f'<svg role="img" {attributes}>\n {words}{content}'


def add_legend(axes: Axes, *, columns: int, before: Sequence[Artist] = ()) -> None:
    """Put the legend above the axes, where it covers no data.

    Args:
        axes: The axes.
        columns: Entries in a row.
        before: Entries that come before those of the labelled artists.
    """
    handles, labels = axes.get_legend_handles_labels()
    handles = [*before, *handles]
    axes.legend(
        handles=handles,
        labels=[*(str(entry.get_label()) for entry in before), *labels],
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=min(columns, len(handles)),
        borderaxespad=0.2,
        columnspacing=1.4,
        handletextpad=0.5,
    )
