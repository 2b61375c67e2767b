"""Collect the record of a run in a pass over its log, in memory that does not grow with the run."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from passafe_protocol.messages import FilterStatus, PlantPhase
from passafe_protocol.topics import COMMAND, EVENT, INPUT, LINK_EVENT, LINK_STATE, STATE, TICK
from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.log.message_block import MessageBlock
from passafe_services.log.message_columns import RECORD
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.plant_evaluator import PlantEvaluator

from passafe_dashboard.run_record.bucket_table import BucketTable, FloatArray, IntArray
from passafe_dashboard.run_record.count_table import CountTable
from passafe_dashboard.run_record.detail_blocks import DetailBlock, DetailBlocks
from passafe_dashboard.run_record.plant_timeline import PlantTimeline
from passafe_dashboard.run_record.run_events import EventList
from passafe_dashboard.run_record.signals import SEVERITY, STATE_FIELDS, TICK_FIELDS, SignalLayout, StateSamples
from passafe_dashboard.run_record.spans import SpanRecorder

DETAIL: Final = 512
"""Samples in a stretch that is kept sample by sample."""

NUMBERS: Final = 300_000
"""Numbers of a table in its buckets, and as many again sample by sample: a page of noise alone stays under 5 MB."""

FEWEST_BUCKETS: Final = 1024
MOST_BUCKETS: Final = 16_384
COUNT_WIDTH_NS: Final = 250_000_000
MOST_COUNTS: Final = 600
TOPIC_COUNTS: Final = {COMMAND: "commands", TICK: "ticks", INPUT: "inputs", STATE: "states"}
LINK_EVENT_FIELDS: Final = ("link", "effect", "cause")


class _LastState(NamedTuple):
    """Newest state of a session, from which the next one is predicted."""

    session: int
    sequence: int
    t_ns: int
    x: FloatArray
    u: FloatArray


class RunCollector:
    """Record of a run: a consumer of a pass over its log.

    Args:
        scenario: The run's scenario.
        evaluator: Functions of it.
    """

    def __init__(self, scenario: Scenario, evaluator: PlantEvaluator) -> None:
        robot = robot_of(scenario)
        self.scenario = scenario
        self.layout = layout = SignalLayout.of(scenario, robot)
        self._evaluator = evaluator
        period_ns = round(scenario.dt_s * 1e9)
        ticks, states, places = layout.tick_columns, layout.state_columns, layout.place_columns
        self.ticks = BucketTable(ticks, width_ns=period_ns, most=_buckets(2 * len(ticks)))
        self.states = BucketTable(states, places, width_ns=period_ns, most=_buckets(2 * len(states) + len(places)))
        self.tick_details = DetailBlocks(
            lowest=_numbers(ticks, ("tank_j", "psi_", "allowed")),
            highest=_numbers(
                ticks, ("status", "held_back", "slack_w", "state_age_ms", "command_age_ms", "step_us", "late_us")
            ),
            most=NUMBERS // len(ticks),
        )
        self.state_details = DetailBlocks(
            lowest=_numbers(states, ("h_", "power_margin_w")),
            highest=_numbers(states, ("phase", "residual", "late_us")),
            most=NUMBERS // (len(states) + len(places)),
        )
        self.counts = CountTable(width_ns=COUNT_WIDTH_NS, most=MOST_COUNTS)
        self.clock = PlantTimeline()
        self.events = EventList()
        self.below_zero = [SpanRecorder() for _ in layout.barriers]
        self.fallbacks = {status: SpanRecorder() for status in FilterStatus if status.is_fallback}
        self.phases = {phase: SpanRecorder() for phase in (PlantPhase.HOLDING, PlantPhase.FAIL_SAFE)}
        self._last: _LastState | None = None

    @property
    def wants(self) -> Wants:
        """Columns that the record is made of."""
        return {
            TICK.name: TICK_FIELDS,
            STATE.name: STATE_FIELDS,
            LINK_EVENT.name: LINK_EVENT_FIELDS,
            LINK_STATE.name: (RECORD,),
            EVENT.name: (RECORD,),
        }

    def take(self, part: LogSlice) -> None:
        """Take the next messages."""
        for topic, name in TOPIC_COUNTS.items():
            for block in part.blocks(topic.name):
                self.counts.add(name, block.numbers("header.wall_ns"))
        for block in part.blocks(TICK.name):
            self._take_ticks(block)
        for block in part.blocks(STATE.name):
            self._take_states(block)
        for block in part.blocks(LINK_EVENT.name):
            self._take_link_events(block)
        for block in part.blocks(EVENT.name):
            for header, event in block.objects(RECORD):
                self.events.take_event(header, event)
        for block in part.blocks(LINK_STATE.name):
            for header, state in block.objects(RECORD):
                self.events.take_link(header, state)

    def _take_ticks(self, block: MessageBlock) -> None:
        rows = self.layout.tick_rows(block)
        t_ns = block.numbers("effective_plant_ns")[rows]
        values = self.layout.tick_values(block)[:, rows]
        self.ticks.add(t_ns, values)
        status = values[0]
        for fallback, spans in self.fallbacks.items():
            spans.add(t_ns, status == SEVERITY[fallback], -status)
        for part in _stretches(t_ns, values):
            worst = part.values[0].max()
            turned = worst > SEVERITY[FilterStatus.MODIFIED] and part.values[0].min() < worst
            self.tick_details.add(part, asked=bool(turned))

    def _take_states(self, block: MessageBlock) -> None:
        samples = StateSamples.of(block, self.layout)
        if not samples.t_ns.size:
            return
        self.clock.add(block.numbers("header.wall_ns"), block.numbers("plant_ns"))
        t_s = samples.t_ns / 1e9
        h = self._evaluator.h(samples.x, t_s)
        computed = [
            samples.phase,
            self._evaluator.power_margin(samples.x, samples.u),
            self._residuals(samples),
            samples.late_us,
            samples.lead_ms,
            samples.stored_j,
        ]
        values = np.vstack([*computed, h, self.layout.places(samples.x, t_s)])
        self.states.add(samples.t_ns, values)
        for below, spans in zip(h, self.below_zero, strict=True):
            spans.add(samples.t_ns, below < 0, below)
        for missing, spans in self.phases.items():
            spans.add(samples.t_ns, samples.phase == missing, -samples.phase)
        for part in _stretches(samples.t_ns, values):
            self.state_details.add(part, asked=bool(part.values[0].max() > PlantPhase.RUNNING))

    def _residuals(self, samples: StateSamples) -> FloatArray:
        """Return the distance of each state from the model's prediction from the one before, NaN where there is none.

        It is ‖x_{k+1} − flow(x_k, u_k)‖∞ / (1 + ‖x_{k+1}‖∞), as the review judges it.
        """
        sequence, t_ns, x, u = samples.sequence, samples.t_ns, samples.x, samples.u
        last = self._last
        if last is not None and last.session == samples.session:
            sequence, t_ns = np.append(last.sequence, sequence), np.append(last.t_ns, t_ns)
            x, u = np.hstack([last.x, x]), np.hstack([last.u, u])
        self._last = _LastState(samples.session, int(sequence[-1]), int(t_ns[-1]), x[:, -1:], u[:, -1:])
        steps_ns = np.diff(t_ns)
        follows = (np.diff(sequence) == 1) & (steps_ns > 0)
        residuals = np.full(t_ns.size, np.nan)
        for step_ns in np.unique(steps_ns[follows]).tolist():
            (begun,) = np.nonzero(follows & (steps_ns == step_ns))
            reached = x[:, begun + 1]
            error = np.abs(reached - self._evaluator.flow(x[:, begun], u[:, begun], step_ns / 1e9))
            residuals[begun + 1] = error.max(axis=0) / (1 + np.abs(reached).max(axis=0))
        return residuals[-samples.t_ns.size :]

    def _take_link_events(self, block: MessageBlock) -> None:
        walls_ns = block.numbers("header.wall_ns")
        links, effects, causes = (block.texts(path) for path in LINK_EVENT_FIELDS)
        for link in links.words:
            for effect in effects.words:
                for cause in causes.words:
                    rows = links.are(link) & effects.are(effect) & causes.are(cause)
                    self.counts.add(f"{link}: {effect}{f' ({cause})' if cause else ''}", walls_ns[rows])


def _stretches(t_ns: IntArray, values: FloatArray) -> list[DetailBlock]:
    """Return samples in stretches of at most ``DETAIL``, each with numbers of its own."""
    starts = range(0, t_ns.size, DETAIL)
    return [DetailBlock(t_ns[at : at + DETAIL].copy(), values[:, at : at + DETAIL].copy()) for at in starts]


def _buckets(numbers: int) -> int:
    return max(FEWEST_BUCKETS, min(MOST_BUCKETS, NUMBERS // numbers))


def _numbers(columns: Sequence[str], wanted: Sequence[str]) -> list[int]:
    return [number for number, name in enumerate(columns) if name.startswith(tuple(wanted))]
