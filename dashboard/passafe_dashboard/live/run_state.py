"""Hold the state of one run of the plant: newest messages, decimated signals and counts."""

from collections.abc import Sequence
from math import isfinite

from passafe_protocol.messages import FilterStatus, FilterTick, LinkEvent, PlantPhase, PlantState
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.fallback_record import FallbackRecord

from passafe_dashboard.columns import ColumnLayout
from passafe_dashboard.decimation import DecimatedSeries, WorstSample


class RunState:
    """State of one run.

    Attributes:
        number: Counts runs from 0.
        tick: Newest FilterTick.
        state: Newest PlantState.
        ticks: Decimated columns of the filter.
        states: Decimated columns of the plant.
        status_counts: Ticks by status.
        fallbacks: Ticks in a fallback.
        drive: What moved the robot.
        link_effects: Messages that a link affected, by link and effect.
        mismatched: Messages whose numbers do not fit the scenario.
        h_possible: Smallest that h may be where a state that was read with an error is out of a barrier.

    Args:
        number: Number of the run.
        layout: Columns of its scenario.
        period_ns: Period of a tick, ns.
        bin_ns: Width of a bin of the decimated columns, ns.
        capacity: Rows kept of them.
    """

    def __init__(self, number: int, layout: ColumnLayout, *, period_ns: int, bin_ns: int, capacity: int) -> None:
        self.number = number
        self.tick: FilterTick | None = None
        self.state: PlantState | None = None
        self.ticks = DecimatedSeries(layout.tick_columns, bin_ns=bin_ns, capacity=capacity)
        self.states = DecimatedSeries(layout.state_columns, bin_ns=bin_ns, capacity=capacity)
        self.status_counts = dict.fromkeys(FilterStatus, 0)
        self.fallbacks = FallbackRecord(period_ns)
        self.drive = DriveRecord()
        self.link_effects: dict[tuple[str, str], int] = {}
        self.mismatched = 0
        self.h_possible: Extremum | None = None
        self._layout = layout

    @property
    def worst(self) -> dict[str, WorstSample]:
        """Lowest values and when they occurred, by column."""
        return self.ticks.worst | self.states.worst

    def add_tick(self, tick: FilterTick) -> None:
        """Add a tick to columns and counts."""
        self.status_counts[tick.status] += 1
        self.fallbacks.add(tick.status, tick.effective_plant_ns)
        self.drive.add_tick(tick.status, tick.effective_plant_ns)
        self._add_row(self.ticks, tick.effective_plant_ns, self._layout.tick_values(tick))

    def add_state(self, state: PlantState, h: Sequence[float] | None) -> None:
        """Add a state, with h of every barrier at it, to the columns; without h it does not fit the scenario."""
        if state.phase is not PlantPhase.WAITING:
            self.drive.add_state(state.plant_ns, runs=state.phase is PlantPhase.RUNNING)
        self._add_row(self.states, state.plant_ns, None if h is None else self._layout.state_values(state, h))

    def add_possible_h(self, possible: Extremum) -> None:
        """Add what h of the worst barrier may be at a state that was read with an error."""
        self.h_possible = possible if self.h_possible is None else min(self.h_possible, possible)

    def show_tick(self, tick: FilterTick) -> None:
        """Show a tick in full unless it was reordered."""
        if self.tick is None or tick.tick > self.tick.tick:
            self.tick = tick

    def show_state(self, state: PlantState) -> None:
        """Show a state in full unless it was reordered."""
        if self.state is None or state.plant_ns >= self.state.plant_ns:
            self.state = state

    def add_link_event(self, event: LinkEvent) -> None:
        """Count an effect of a link."""
        key = (event.link, event.effect)
        self.link_effects[key] = self.link_effects.get(key, 0) + 1

    def _add_row(self, series: DecimatedSeries, time_ns: int, values: list[float] | None) -> None:
        if values is None or not all(map(isfinite, values)):
            self.mismatched += 1
            return
        series.add(time_ns, values)
