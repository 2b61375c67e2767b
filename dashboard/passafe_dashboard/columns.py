"""Name the columns that charts draw, for feed, charts, page and report alike.

Two tables share a time axis in seconds of plant time. ``ticks`` holds the results of the filter,
``states`` the measurements of the plant. Each row covers ``start_s`` to ``time_s``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from passafe_protocol.messages import FilterTick, PlantState
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.body_in_space import BodyInSpace
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.scenarios.schema import Scenario

from passafe_dashboard.decimation import Keep

TIME: Final = "time_s"
START: Final = "start_s"
POWER_MARGIN: Final = "power_margin_w"
TANK: Final = "tank_j"
SLACK: Final = "slack_w"
STATE_AGE: Final = "state_age_ms"
COMMAND_AGE: Final = "command_age_ms"
STATUS: Final = "status"
P1: Final = "p1_m"
P2: Final = "p2_m"
PLACES: Final = ((P1, P2), ("p3_m", "p4_m"))
"""Columns of the position of each point that the robot moves in the plane."""


def measured_h(barrier: int) -> str:
    """Return the column of h of barrier number ``barrier``, evaluated at the plant's state."""
    return f"h_{barrier}"


def psi(barrier: int, level: int) -> str:
    """Return the column of ψ of barrier number ``barrier`` at ``level``; level 0 is the filter's h."""
    return f"psi_{barrier}_{level}"


def moving_table(barrier: int) -> str:
    """Return the name under which the displacement of an obstacle that moves is sent."""
    return f"moving_{barrier}"


@dataclass(frozen=True, kw_only=True)
class ColumnLayout:
    """Columns of one scenario, and their values for a message.

    Attributes:
        barriers: Every barrier, in the scenario's order.
        levels: Number of ψ of each barrier, h included.
        points: Number of points in the plane the state begins with; 0 for joints.
        states: Length of the state.
        drawn: Points of a robot that is not drawn where its state begins; ``None``: there.
        body: Points and spheres of a robot that is drawn in space; ``None`` of others.
    """

    barriers: tuple[SingleBarrier, ...]
    levels: tuple[int, ...]
    points: int = 1
    states: int = 2
    drawn: DrawnPlaces | None = None
    body: BodyInSpace | None = None

    @classmethod
    def of(cls, scenario: Scenario) -> "ColumnLayout":
        """Return the layout of a scenario: a barrier with r + 1 class-K functions has ψ₀ … ψ_r."""
        robot = None if scenario.plant.robot is None else robot_of(scenario)
        return cls(
            barriers=scenario.barriers,
            levels=tuple(len(barrier.class_k) for barrier in scenario.barriers),
            points=scenario.plant.robot_model.points,
            states=len(scenario.plant.x0),
            drawn=None if robot is None else DrawnPlaces.of(robot),
            body=None if robot is None else BodyInSpace.of(robot),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Name of each barrier."""
        return tuple(barrier.name for barrier in self.barriers)

    @property
    def h_unit(self) -> str:
        """Unit of h for an axis label, also when barriers differ."""
        units = sorted({barrier.h_unit for barrier in self.barriers})
        return " or ".join(units) or "m"

    @property
    def chain(self) -> tuple[tuple[int, int], ...]:
        """(barrier, level) of every ψ, in the order in which a tick lists them."""
        return tuple((i, level) for i, count in enumerate(self.levels) for level in range(count))

    @property
    def tick_columns(self) -> dict[str, Keep]:
        """Value kept of each column of a FilterTick; ``status`` is its severity."""
        return {
            STATUS: Keep.HIGHEST,
            POWER_MARGIN: Keep.LOWEST,
            TANK: Keep.LOWEST,
            SLACK: Keep.HIGHEST,
            STATE_AGE: Keep.HIGHEST,
            COMMAND_AGE: Keep.HIGHEST,
            **{psi(i, level): Keep.LOWEST for i, level in self.chain},
        }

    @property
    def place_columns(self) -> tuple[str, ...]:
        """Columns of the position of every point."""
        return tuple(column for place in PLACES[: self.points] for column in place)

    @property
    def state_columns(self) -> dict[str, Keep]:
        """Value kept of each column of a PlantState."""
        return {
            **dict.fromkeys(self.place_columns, Keep.LAST),
            **{measured_h(i): Keep.LOWEST for i in range(len(self.barriers))},
        }

    def tick_values(self, tick: FilterTick) -> list[float] | None:
        """Return the values of ``tick_columns``, or ``None`` for a tick whose barriers are not this scenario's."""
        if len(tick.barriers) != len(self.levels):
            return None
        values = [
            tick.status.severity,
            tick.power_margin,
            tick.tank_j,
            tick.slack,
            tick.state_age_ns * 1e-6,
            tick.command_age_ns * 1e-6,
        ]
        for chain, count in zip(tick.barriers, self.levels, strict=True):
            if len(chain.psi) != count:
                return None
            values.extend(chain.psi)
        return values

    def state_values(self, state: PlantState, h: Sequence[float]) -> list[float]:
        """Return the values of ``state_columns`` for a state that fits, with h of every barrier at that state."""
        return [*(number for place in self.places(state.x)[: self.points] for number in place), *h]

    def places(self, x: Sequence[float]) -> list[tuple[float, float]]:
        """Return the points that are drawn of a state, m."""
        if self.drawn is not None:
            return self.drawn.at(x[: self.states])[0]
        return [(x[2 * point], x[2 * point + 1]) for point in range(self.points)]

    def fits(self, state: PlantState) -> bool:
        """Return whether a state is long enough to be one of this scenario."""
        return len(state.x) >= self.states


def drawn_columns(columns: Sequence[str]) -> tuple[str, ...]:
    """Return the columns of a row of a frame: begin, end and the table's own."""
    return (START, TIME, *columns)
