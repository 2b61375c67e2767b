"""Make the live page's markup and charts, once a scenario."""

from typing import Final, NamedTuple

from passafe_protocol.topics import LINKS
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.verdict_so_far import TOLERANCES

from passafe_dashboard.barrier_values import BarrierValues
from passafe_dashboard.charts.live_charts import ROBOT, STATES, TICKS, LiveCharts, live_charts
from passafe_dashboard.columns import ColumnLayout, drawn_columns
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.drive_state import drive_setup
from passafe_dashboard.live.feed import Feed, scenario_id
from passafe_dashboard.markup import TEMPLATES
from passafe_dashboard.palette import STATUS_STYLES


class ChartText(NamedTuple):
    """Heading of a chart on the page, and its description for screen readers."""

    name: str
    heading: str
    description: str


CHART_TEXTS: Final = (
    ChartText(
        "plane",
        "Robot in the plane",
        "Obstacles, the trail of the robot and its position now. The numbers are in the table “Barriers”.",
    ),
    ChartText(
        "h",
        "Barriers h",
        "h of every barrier over time with the line h = 0: below it the robot is in the forbidden region. "
        "Each point is the lowest value in a thirtieth of a second.",
    ),
    ChartText(
        "chain",
        "ψ chain",
        "ψ₁ to ψ_r of every barrier over time on a symmetric logarithmic axis with the line ψ = 0.",
    ),
    ChartText(
        "power_margin",
        "Power margin",
        "Power margin over time with the line 0: below it the robot generates energy.",
    ),
    ChartText("tank", "Energy tank", "Energy left in the tank over time with the line 0."),
    ChartText(
        "status",
        "Filter status over time",
        "A row for each status, the worst on top; the worst status of each thirtieth of a second is marked.",
    ),
    ChartText("ages", "Ages of state and command", "Highest age of plant state and operator command."),
)


class LivePage:
    """Markup and charts of the live page for the feed's scenario.

    Making the charts of a new scenario takes about half a second: call from a worker thread.

    Args:
        feed: State of the page.
        window_s: Stretch of time that charts show.
    """

    def __init__(self, feed: Feed, *, window_s: float) -> None:
        self._feed = feed
        self._window_s = window_s

    def charts(self) -> LiveCharts:
        """Return the charts of the feed's scenario; none while no scenario is known."""
        return self._charts_of(self._feed.scenario)

    def html(self) -> str:
        """Return the page's markup."""
        scenario = self._feed.scenario
        charts = self._charts_of(scenario)
        return TEMPLATES.get_template("live.html").render(
            scenario=scenario,
            texts=[text for text in CHART_TEXTS if text.name in charts.divs],
            divs=charts.divs,
            links=list(LINKS),
            statuses=[(status.name, style) for status, style in STATUS_STYLES.items()],
            setup=json_text(self._setup(scenario)).replace("<", "\\u003c"),
        )

    def _setup(self, scenario: Scenario | None) -> dict[str, object]:
        """Return what the page's script needs to read frames."""
        columns: dict[str, object] = {}
        moved: dict[str, tuple[float, float]] = {}
        if scenario is not None:
            layout = ColumnLayout.of(scenario)
            columns = {
                TICKS: drawn_columns(tuple(layout.tick_columns), layout.log_columns),
                STATES: drawn_columns(tuple(layout.state_columns), ()),
                ROBOT: layout.place_columns,
            }
            moved = BarrierValues(scenario).displacements_m(0.0)
        return {
            "layout": scenario_id(scenario),
            "columns": columns,
            "moved_m": moved,
            "rows": self._feed.capacity,
            "drive": drive_setup(scenario),
            "tolerances": TOLERANCES.model_dump(),
        }

    def _charts_of(self, scenario: Scenario | None) -> LiveCharts:
        if scenario is None:
            return LiveCharts(script="", divs={})
        layout, x0 = ColumnLayout.of(scenario), scenario.plant.x0
        starts = tuple((x0[2 * i], x0[2 * i + 1]) for i in range(layout.points))
        return live_charts(layout, starts=starts, window_s=self._window_s)
