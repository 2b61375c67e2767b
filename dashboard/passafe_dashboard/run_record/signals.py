"""Name the signals of a run's record, and read them from the columns of a pass over its log."""

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import BY_SEVERITY, FilterStatus, PlantPhase
from passafe_services.log.actual_states import STATE_PATHS, actual_states
from passafe_services.log.message_block import MessageBlock
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.motion import MotionKind
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.scenarios.schema import Scenario

from passafe.models.robot import Robot
from passafe_dashboard.number_text import number
from passafe_dashboard.run_record.bucket_table import FloatArray, IntArray

SEVERITY: Final = {status: rank for rank, status in enumerate(BY_SEVERITY, start=1)}
"""Rank of each status, from 1, the best, on."""

TICK_FIELDS: Final = (
    "status",
    "effective_plant_ns",
    "tank_j",
    "slack",
    "state_age_ns",
    "command_age_ns",
    "header.scheduled_ns",
    "header.started_ns",
    "header.sent_ns",
    "override.held_back",
    "override.allowed_fraction",
    "override.distance_to_infeasibility",
    "barriers.psi",
    "rows.active",
    "rows.name",
    "u_nominal",
    "u",
)
STATE_FIELDS: Final = (
    "plant_ns",
    *STATE_PATHS,
    "u",
    "phase",
    "energy_stored_j",
    "input_lead_ns",
    "header.scheduled_ns",
    "header.started_ns",
)
PURE_NUMBER: Final = "1"
"""Unit of a barrier without one."""

NS_PER_MS: Final = 1e6
NS_PER_US: Final = 1e3

Rows: TypeAlias = NDArray[np.intp]

_SEVERITY_OF: Final = np.array([0.0, *(float(SEVERITY[status]) for status in sorted(FilterStatus))])


@dataclass(frozen=True, kw_only=True)
class SignalLayout:
    """Signals of one scenario.

    Attributes:
        barriers: Every barrier, in the scenario's order.
        levels: Number of ψ of each barrier, h included.
        states: Length of the state.
        inputs: Length of the input.
        points: Number of points in the plane that are drawn; 0 for joints.
        coordinates: Number of coordinates of the position, or of what is drawn: two a point, and the body's angle.
        drawn: Points of a robot that is not drawn where its state begins; ``None``: there.
    """

    barriers: tuple[SingleBarrier, ...]
    levels: tuple[int, ...]
    states: int
    inputs: int
    points: int
    coordinates: int
    drawn: DrawnPlaces | None = None

    @classmethod
    def of(cls, scenario: Scenario, robot: Robot) -> "SignalLayout":
        """Return the layout of a scenario and its robot."""
        places = DrawnPlaces.of(robot)
        drawn = places if scenario.plant.robot is not None and places.count else None
        return cls(
            barriers=scenario.barriers,
            levels=tuple(len(barrier.class_k) for barrier in scenario.barriers),
            states=len(scenario.plant.x0),
            inputs=robot.system.m,
            points=robot.points if drawn is None else drawn.count,
            coordinates=int(robot.position.numel()) if drawn is None else 2 * drawn.count + drawn.has_heading,
            drawn=drawn,
        )

    def h_unit(self, barrier: int) -> str:
        """Return the unit of h of a barrier, empty for a pure number."""
        unit = self.barriers[barrier].h_unit
        return "" if unit == PURE_NUMBER else unit

    def h_text(self, barrier: int, value: float) -> str:
        """Return a value of h of a barrier with its unit."""
        return f"{number(value, 3)} {self.h_unit(barrier)}".rstrip()

    @property
    def rows(self) -> tuple[str, ...]:
        """Rows of the filter's program, in the order of the charts."""
        return (*(barrier.name for barrier in self.barriers), "passivity")

    @property
    def tick_columns(self) -> tuple[str, ...]:
        """Signals of a filter tick."""
        psi = (f"psi_{i}_{level}" for i, count in enumerate(self.levels) for level in range(count))
        return (
            "status",
            "tank_j",
            "slack_w",
            "state_age_ms",
            "command_age_ms",
            "step_us",
            "late_us",
            "allowed",
            "held_back",
            "room",
            *psi,
            *(f"active_{i}" for i in range(len(self.rows))),
            *(f"asked_{i}" for i in range(self.inputs)),
            *(f"sent_{i}" for i in range(self.inputs)),
        )

    @property
    def state_columns(self) -> tuple[str, ...]:
        """Signals of a plant state, and what is recomputed from it."""
        h = (f"h_{i}" for i in range(len(self.barriers)))
        return ("phase", "power_margin_w", "residual", "late_us", "lead_ms", "stored_j", *h)

    @property
    def moving(self) -> tuple[tuple[int, MotionKind], ...]:
        """Numbers of the barriers whose outline moves, and how."""
        outlines = ((i, barrier.outline) for i, barrier in enumerate(self.barriers))
        return tuple((i, one.motion) for i, one in outlines if one is not None and one.motion is not None)

    @property
    def place_columns(self) -> tuple[str, ...]:
        """Coordinates of the position, and displacements of the outlines that move."""
        displacements = (f"d_{i}_{axis}" for i, _ in self.moving for axis in range(2))
        return (*(f"q_{i}" for i in range(self.coordinates)), *displacements)

    def places(self, x: FloatArray, t_s: FloatArray) -> FloatArray:
        """Return the values of ``place_columns`` for states x, shape (n, N), at plant times t_s, s, shape (N,)."""
        here = x[: self.coordinates] if self.drawn is None else self.drawn.many(x)
        return np.vstack([here, *(motion.displacements_m(t_s) for _, motion in self.moving)])

    def tick_rows(self, block: MessageBlock) -> Rows:
        """Return which ticks are of this scenario, by their places in the block."""
        inputs = (block.ragged("u").counts == self.inputs) & (block.ragged("u_nominal").counts == self.inputs)
        return np.flatnonzero(inputs & (block.ragged("barriers.psi").counts == sum(self.levels)))

    def tick_values(self, block: MessageBlock) -> FloatArray:
        """Return the signals of ticks, shape (columns, N); NaN where the filter did not know one."""
        started = block.numbers("header.started_ns")
        held_back = block.ragged("override.held_back")
        known = held_back.counts > 0
        return np.vstack(
            [
                _SEVERITY_OF[block.numbers("status")],
                block.numbers("tank_j"),
                block.numbers("slack"),
                _ages_ms(block.numbers("state_age_ns")),
                _ages_ms(block.numbers("command_age_ns")),
                (block.numbers("header.sent_ns") - started) / NS_PER_US,
                (started - block.numbers("header.scheduled_ns")) / NS_PER_US,
                np.where(known, block.numbers("override.allowed_fraction"), np.nan),
                np.where(known, np.sqrt((np.nan_to_num(held_back.matrix(self.inputs)) ** 2).sum(axis=1)), np.nan),
                np.where(known, block.numbers("override.distance_to_infeasibility"), np.nan),
                block.matrix("barriers.psi", sum(self.levels)),
                self._active(block),
                block.matrix("u_nominal", self.inputs),
                block.matrix("u", self.inputs),
            ]
        )

    def _active(self, block: MessageBlock) -> FloatArray:
        """Return 1 for every row that was active in a tick, else 0, shape (rows, N)."""
        active, names = block.ragged("rows.active"), block.texts("rows.name")
        found = np.zeros((len(self.rows), len(block)))
        ticks = active.row_numbers
        for place, name in enumerate(self.rows):
            found[place, ticks[active.values & names.are(name)]] = 1.0
        return found


@dataclass(frozen=True, kw_only=True, eq=False)
class StateSamples:
    """Plant states of one session, in order, as arrays.

    Attributes:
        session: Number of the session.
        sequence: Number of each message, shape (N,).
        t_ns: Plant time, ns, shape (N,).
        x: State, the true one where the plant knows it, shape (n, N).
        u: Input in force from this state until the next, shape (m, N).
        phase: Origin of the input, shape (N,).
        late_us: Lateness of the step, µs, shape (N,).
        lead_ms: Time by which the newest input came before it was due, ms, shape (N,).
        stored_j: V(x), J, shape (N,).
    """

    session: int
    sequence: IntArray
    t_ns: IntArray
    x: FloatArray
    u: FloatArray
    phase: FloatArray
    late_us: FloatArray
    lead_ms: FloatArray
    stored_j: FloatArray

    @classmethod
    def of(cls, block: MessageBlock, layout: SignalLayout) -> "StateSamples":
        """Return the samples of a moving plant whose states are of the scenario."""
        fits = (block.ragged("x").counts == layout.states) & (block.ragged("u").counts == layout.inputs)
        moving = np.flatnonzero(fits & (block.numbers("phase") != PlantPhase.WAITING))
        late_ns = block.numbers("header.started_ns") - block.numbers("header.scheduled_ns")
        return cls(
            session=block.session,
            sequence=block.sequence[moving].astype(np.int64),
            t_ns=block.numbers("plant_ns")[moving],
            x=actual_states(block, layout.states)[:, moving],
            u=block.matrix("u", layout.inputs)[:, moving],
            phase=block.numbers("phase")[moving].astype(np.float64),
            late_us=late_ns[moving] / NS_PER_US,
            lead_ms=block.numbers("input_lead_ns")[moving] / NS_PER_MS,
            stored_j=block.numbers("energy_stored_j")[moving],
        )


def _ages_ms(ages_ns: IntArray) -> FloatArray:
    return np.where(ages_ns >= 0, ages_ns / NS_PER_MS, np.nan)
