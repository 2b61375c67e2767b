"""Make the live page's markup and what its scripts need to know of the scenario."""

from typing import Any

from passafe_protocol.messages import PlantPhase
from passafe_protocol.networks import NETWORKS
from passafe_protocol.topics import LINKS
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.verdict_so_far import TOLERANCES

from passafe_dashboard.columns import ColumnLayout, drawn_columns
from passafe_dashboard.json_text import json_text
from passafe_dashboard.live.drive_state import drive_setup
from passafe_dashboard.live.feed import Feed, scenario_id
from passafe_dashboard.live.live_charts import live_charts
from passafe_dashboard.live.scene_setup import live_scene
from passafe_dashboard.markup import TEMPLATES
from passafe_dashboard.palette import PHASE_STYLES, STATUS_STYLES


class LivePage:
    """Markup and setup of the live page for the feed's scenario.

    Args:
        feed: State of the page.
        window_s: Stretch of time that charts show.
    """

    def __init__(self, feed: Feed, *, window_s: float) -> None:
        self._feed = feed
        self._window_s = window_s

    def html(self) -> str:
        """Return the page's markup."""
        scenario = self._feed.scenario
        return TEMPLATES.get_template("live.html").render(
            scenario=scenario,
            statuses=[(status.name, style) for status, style in STATUS_STYLES.items()],
            setup=json_text(self._setup(scenario)).replace("<", "\\u003c"),
        )

    def _setup(self, scenario: Scenario | None) -> dict[str, Any]:
        """Return what the page's scripts need to read frames."""
        setup: dict[str, Any] = {
            "layout": scenario_id(scenario),
            "rows": self._feed.capacity,
            "drive": drive_setup(scenario),
            "window_s": self._window_s,
            "tolerances": TOLERANCES.model_dump(),
            "links": list(LINKS),
            "networks": [{"name": name, "title": model.title} for name, model in NETWORKS.items()],
            "statuses": {status.name: style._asdict() for status, style in STATUS_STYLES.items()},
            "bands": _bands(),
        }
        return setup if scenario is None else setup | _of_scenario(scenario)


def _of_scenario(scenario: Scenario) -> dict[str, Any]:
    layout = ColumnLayout.of(scenario)
    return {
        "columns": {
            "ticks": drawn_columns(tuple(layout.tick_columns)),
            "states": drawn_columns(tuple(layout.state_columns)),
        },
        "scene": live_scene(scenario),
        "charts": [plan.payload() for plan in live_charts(layout)],
        "script": scenario.operator.source.kind,
        "input_unit": scenario.plant.robot_model.input_unit,
        "scenario": scenario.name,
    }


def _bands() -> dict[str, Any]:
    """Return name and colour of each status and phase, by the number that stands for it in a column."""
    return {
        "status": {
            str(status.severity): {"name": status.name, "colour": style.background}
            for status, style in STATUS_STYLES.items()
        },
        "phase": {str(phase.value): {"name": phase.name, "colour": PHASE_STYLES[phase]} for phase in PlantPhase},
    }
