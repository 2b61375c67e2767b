"""Make pictures and pages that set runs side by side."""

from collections.abc import Sequence

from markupsafe import Markup
from passafe_services.tools.compare.comparison import Comparison
from passafe_services.tools.compare.run_metrics import NUMERIC
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog

from passafe_dashboard.markup import TEMPLATES, report_css
from passafe_dashboard.number_text import number
from passafe_dashboard.pictures.overlay_picture import OverlaidRun, overlay_picture
from passafe_dashboard.run_report import series_of


def overlay(logs: Sequence[RunLog], origins_s: Sequence[float], names: Sequence[str], notes: Sequence[str]) -> str:
    """Return the SVG of logged runs over one another.

    Args:
        logs: The logs.
        origins_s: Plant time of each that is drawn as zero, s.
        names: Their names.
        notes: What the picture has to say.
    """
    runs = [
        OverlaidRun(name, series_of(log, CoreEvaluator(log.identity.scenario)), origin)
        for name, log, origin in zip(names, logs, origins_s, strict=True)
    ]
    return overlay_picture(runs, title=" and ".join(names), notes=notes)


def comparison_page(comparison: Comparison, names: Sequence[str], picture: str, notes: Sequence[str]) -> str:
    """Return a page that refers to no other file or host.

    Args:
        comparison: The runs.
        names: Their names.
        picture: The overlay, SVG.
        notes: What the page has to say.
    """
    rows = [("verdict", [run.metrics.words for run in comparison.runs])]
    rows += [(name, [number(getattr(run.metrics, name)) for run in comparison.runs]) for name in NUMERIC]
    return TEMPLATES.get_template("comparison.html").render(
        names=names,
        rows=rows,
        notes=notes,
        align=comparison.align,
        picture=Markup(picture),  # noqa: S704 - made here, of numbers and escaped text
        css=report_css(),
    )
