"""Write the HTML report of an experiment and, where an axis was bisected, the picture of its boundaries."""

from collections.abc import Sequence
from pathlib import Path

from passafe_services.tools.experiment.kept_logs import KeptLog
from passafe_services.tools.experiment.live_agreement import Agreement
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.summary import ExperimentSummary

from passafe_dashboard.number_text import number
from passafe_dashboard.pictures.line_chart import line_chart_picture
from passafe_dashboard.reports.experiment_charts import boundary_charts
from passafe_dashboard.reports.experiment_page import KeptLine, experiment_page


def write_experiment_report(
    plan: Plan, summary: ExperimentSummary, kept: Sequence[KeptLog], agreement: Sequence[Agreement], folder: Path
) -> None:
    """Write ``report.html`` and, where an axis was bisected, ``boundaries.svg``.

    Args:
        plan: The experiment with its results.
        summary: Summary of the results.
        kept: Logs of single runs, inside the folder.
        agreement: Metrics of runs that were made live too.
        folder: An existing folder.
    """
    worst = plan.experiment.worst.metric
    lines = [
        KeptLine(
            cell=plan.cells[log.result.run.cell].describe(),
            seed=log.result.run.seed,
            file=str(log.path.relative_to(folder)),
            metric=f"{worst} {number(None if log.result.metrics is None else log.result.metrics.number(worst))}",
        )
        for log in kept
    ]
    (folder / "report.html").write_text(experiment_page(plan, summary, lines, agreement), encoding="utf-8")
    charts = boundary_charts(plan.experiment, summary)
    if charts:
        svg = line_chart_picture(
            charts,
            columns=len(charts) // len(plan.experiment.criteria),
            title=plan.experiment.title,
            description=" ".join(chart.description for chart in charts),
        )
        (folder / "boundaries.svg").write_text(svg, encoding="utf-8")
