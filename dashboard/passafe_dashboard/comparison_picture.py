"""Draw logged runs over one another."""

from collections.abc import Sequence

from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog

from passafe_dashboard.pictures.overlay_picture import OverlaidRun, overlay_picture
from passafe_dashboard.run_series import series_of


def comparison_picture(
    logs: Sequence[RunLog], origins_s: Sequence[float], names: Sequence[str], notes: Sequence[str]
) -> str:
    """Return the SVG of logged runs over one another.

    Args:
        logs: The logs.
        origins_s: Plant time of each that is drawn as zero, s.
        names: Their names.
        notes: Lines below the charts.
    """
    runs = [
        OverlaidRun(name, series_of(log, CoreEvaluator(log.identity.scenario)), origin)
        for name, log, origin in zip(names, logs, origins_s, strict=True)
    ]
    return overlay_picture(runs, title=" and ".join(names), notes=notes)
