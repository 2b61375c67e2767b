"""Make the HTML report of a log."""

from passafe_protocol.messages import FilterTick
from passafe_services.tools.review.plant_evaluator import PlantEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict, trajectory_of

from passafe_dashboard.decimation import NS_PER_S
from passafe_dashboard.reports.run_page import report_page
from passafe_dashboard.run_series import RunSeries, status_spans


def render_report(log: RunLog, evaluator: PlantEvaluator, verdict: Verdict) -> str:
    """Return the report of a run as one self-contained HTML file.

    Args:
        log: Log of the run.
        evaluator: Functions of its scenario.
        verdict: Result of the review.

    Raises:
        SeriesError: The log has no state of the plant: there is nothing to draw.
        MismatchedLogError: Its states have not as many numbers as the scenario's.
    """
    return report_page(
        verdict.model_dump(mode="json"),
        series_of(log, evaluator),
        configuration=log.identity.scenario.model_dump(mode="json"),
        versions=log.identity.versions,
    )


def series_of(log: RunLog, evaluator: PlantEvaluator) -> RunSeries:
    """Return the signals of a logged run; barriers and power margin are recomputed from the plant's states alone.

    Raises:
        SeriesError: The log has no state of the plant.
        MismatchedLogError: Its states have not as many numbers as the scenario's.
    """
    scenario = log.identity.scenario
    trajectory = trajectory_of(log)
    ticks = ((tick.body.effective_plant_ns / NS_PER_S, tick.body.status) for tick in log.of(FilterTick))
    return RunSeries(
        times_s=trajectory.t_s,
        x=trajectory.x,
        u=trajectory.u,
        h=evaluator.h(trajectory.x, trajectory.t_s),
        power_margin_w=evaluator.power_margin(trajectory.x, trajectory.u),
        barriers=scenario.barriers,
        statuses=status_spans(ticks, period_s=scenario.dt_s),
        points=scenario.plant.robot_model.points,
    )
