"""A run as viewers show it: from each message of passafe the messages of the well-known schemas."""

from collections.abc import Iterator, Mapping
from typing import Final

from passafe_protocol.messages import FilterTick, PlantState

from passafe_services.scenarios.schema import Scenario
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.log_messages import LoggedRow
from passafe_services.viewer.log_lines import log_line
from passafe_services.viewer.named_numbers import NamedNumbers
from passafe_services.viewer.scene import Scene
from passafe_services.viewer.view_message import ViewMessage

ROBOT_PERIOD_NS: Final = 20_000_000
"""The robot is shown 50 times a second; its numbers are there for every message."""

BARRIERS_PERIOD_NS: Final = 100_000_000
"""All barriers are shown 10 times a second, so that a viewer that jumps in time has them at once."""


class RunView:
    """View of one run, in the order of its messages.

    Args:
        scenario: Its scenario; without one there is no scene.
        layouts: Layout of each table, by name of the topic.
        start_ns: Time at which ``time_s`` is zero, Unix time, ns.
    """

    def __init__(self, scenario: Scenario | None, layouts: Mapping[str, TableLayout], start_ns: int) -> None:
        self._scene = None if scenario is None else Scene(scenario)
        self._numbers = {name: NamedNumbers(layout) for name, layout in layouts.items()}
        self._start_ns = start_ns
        self._tick: FilterTick | None = None
        self._robot_due_ns = self._barriers_due_ns = 0

    def views(self, row: LoggedRow) -> Iterator[ViewMessage]:
        """Yield what a message shows; the layout of its topic must have noted it."""
        yield self._numbers[row.topic.name].view(row, self._start_ns)
        line = log_line(row.header, row.body, row.log_ns)
        if line is not None:
            yield line
        if isinstance(row.body, FilterTick):
            self._tick = row.body
        elif isinstance(row.body, PlantState) and self._scene is not None:
            yield from self._scenes(self._scene, row.body, row.log_ns)

    def _scenes(self, scene: Scene, state: PlantState, log_ns: int) -> Iterator[ViewMessage]:
        if not 0 <= self._robot_due_ns - log_ns < ROBOT_PERIOD_NS:  # also after a jump of the clock
            self._robot_due_ns = log_ns + ROBOT_PERIOD_NS
            yield from scene.robot(state, self._tick, log_ns)
        if not 0 <= self._barriers_due_ns - log_ns < BARRIERS_PERIOD_NS:
            self._barriers_due_ns = log_ns + BARRIERS_PERIOD_NS
            yield from scene.barriers(state.plant_ns, self._tick, log_ns)
