"""The filter process as a node: predicts, decides, certifies, and tells what it did."""

from collections.abc import Sequence
from typing import Final

from passafe_protocol.messages import (
    FilterStatus,
    OperatorCommand,
    PlantPhase,
    PlantState,
    Received,
    ScenarioInfo,
    Vector,
)
from passafe_protocol.topics import COMMAND, EVENT, INPUT, SCENARIO, STATE, TICK, Topic

from passafe.filter import SafetyPassivityFilter
from passafe.override import Explainer
from passafe_services.filter.event_emitter import OverrideEventEmitter, StatusEventEmitter
from passafe_services.filter.input_sequencer import MOST_AT_ONCE, InputSequencer, UnsequencedInputs
from passafe_services.filter.operator_request import PassThroughRequest
from passafe_services.filter.override_text import OverrideText
from passafe_services.filter.playout_schedule import EffectSchedule
from passafe_services.filter.predictor import NoPrediction, Predictor
from passafe_services.filter.telemetry import STATUS, Telemetry, TickRecord
from passafe_services.node import Outgoing

_STALE: Final = FilterStatus.STALE
_WAITING: Final = PlantPhase.WAITING

MOST_UNACCOUNTED: Final = 256
"""Messages that the first tick accounts for at most: telling of 3000 takes 8 ms, and the plant's inputs wait for it."""


class FilterNode:
    """Decides one input a step, for the plant time at which it will take effect.

    A command that is stale or released (dead-man) fades to u_h = 0; the rows are kept all the same. When the plant's
    state is stale nothing is sent at all: a prediction without states is no ground to act on, and the plant's own
    fail-safe takes over.

    Attributes:
        name: ``filter``.
        subscribes: Commands of the operator, states of the plant.
    """

    name = "filter"
    subscribes: tuple[Topic, ...] = (COMMAND, STATE)

    def __init__(
        self,
        core: SafetyPassivityFilter,
        *,
        period_ns: int,
        foresight: Predictor | NoPrediction,
        series: InputSequencer | UnsequencedInputs,
        schedule: EffectSchedule,
        request: PassThroughRequest,
        state_stale_ns: int,
        starts_nearest: bool,
        explainer: Explainer,
        wording: OverrideText,
        info: ScenarioInfo,
    ) -> None:
        """Start with nothing heard.

        Args:
            core: The filter.
            period_ns: Period of a step, ns.
            foresight: Tells the state at which an input will take effect.
            series: Tells which inputs a step makes.
            schedule: Tells the plant time of a step's input.
            request: What the operator's commands ask for.
            state_stale_ns: Age of the newest state from which nothing is sent, ns.
            starts_nearest: Whether the first input of all is the nearest to û, rather than one step from u = 0.
            explainer: Tells what the filter overrides and why.
            wording: Puts what the filter overrides into words.
            info: Published by the first step.
        """
        system = core.design.system
        self._n, self._m = system.n, system.m
        self._core = core
        self._foresight, self._series, self._schedule = foresight, series, schedule
        self._telemetry = Telemetry(core, explainer)
        self._announcer = StatusEventEmitter()
        self._overrides = OverrideEventEmitter(explainer, wording, max(core.design.limits.magnitude))
        self._request = request
        self._period_ns = period_ns
        self._state_stale_ns = state_stale_ns
        self._starts_nearest = self._starts = starts_nearest
        self._info: ScenarioInfo | None = info
        self._tick = 0
        self._state: PlantState | None = None
        self._state_ns = 0
        self._state_epoch, self._state_sequence = 0, -1
        self._told: TickRecord | None = None
        self._unaccounted: list[Received] = []

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the inputs for the plant and the account of each; nothing before the first plant state.

        There is one input a step, none where nothing may be sent or the schedule moves back, and several where it
        moved forward or steps were left out.

        Args:
            now_ns: When this step was due, monotonic, ns.
            inbox: Commands and states, in order of arrival.
        """
        self._read(inbox)
        outgoing = self._introduce()
        state = self._state
        state_age_ns = now_ns - self._state_ns if now_ns > self._state_ns else 0
        is_blind = state is None or state_age_ns > self._state_stale_ns
        effective = () if state is None or is_blind else self._due(now_ns, state)
        if self._told is None:
            self._unaccounted += inbox
            if not effective:
                self._wait()
                return outgoing if state is None else [*outgoing, *self._status_event(now_ns, _STALE)]
            inbox, self._unaccounted = self._unaccounted, []
        u_h, u_h_rate, command_age_ns, operator_is_stale = self._request.at(now_ns)
        ages = state_age_ns, command_age_ns
        for effective_ns in effective:
            record = self._decide(effective_ns, u_h, u_h_rate, operator_is_stale, inbox, ages, outgoing)
            inbox = ()
            if now_ns >= self._overrides.look_ns:
                overridden = self._overrides.event(now_ns, record.decision)
                if overridden is not None:
                    outgoing.append((EVENT, overridden))
            self._told = record
            outgoing.append((TICK, record))
        told = self._told
        if told is None:
            return outgoing
        status = _STALE if is_blind else told.status
        outgoing += self._status_event(now_ns, status)
        if not effective:  # what was decided last stands
            self._told = told = told.again(status, inbox, *ages)
            outgoing.append((TICK, told))
        return outgoing

    def _wait(self) -> None:
        """Leave no trace of a step of which no tick tells: the first tick accounts for what was consumed before it.

        So a log can be stepped again. A filter that waits for long, for a plant or for another filter's end, begins
        anew now and then.
        """
        self._schedule.restart()
        if len(self._unaccounted) > MOST_UNACCOUNTED:
            self._unaccounted = []
            self._request.restart()
            self._meet_plant(0)

    def _status_event(self, now_ns: int, status: FilterStatus) -> list[Outgoing]:
        if status is self._announcer.settled:
            return []
        event = self._announcer.event(now_ns, status)
        return [] if event is None else [(EVENT, event)]

    def _read(self, inbox: Sequence[Received]) -> None:
        for received in inbox:
            body = received.body
            if type(body) is PlantState:
                if len(body.x) != self._n or not len(body.y) == len(body.u) == self._m:
                    continue  # not the plant of the filter's model
                epoch = received.header.epoch
                if epoch > self._state_epoch:
                    self._meet_plant(epoch)
                newest = self._state
                sequence = received.header.sequence  # one that comes twice is no sign of life
                if (
                    epoch == self._state_epoch
                    and sequence > self._state_sequence
                    and (newest is None or body.plant_ns >= newest.plant_ns)
                ):
                    self._state, self._state_ns, self._state_sequence = body, received.received_ns, sequence
                    self._foresight.confirm(body)
            elif type(body) is OperatorCommand:
                self._request.hear(received, body)

    def _meet_plant(self, epoch: int) -> None:
        """Begin anew with a plant that was started after the one before."""
        self._state_epoch, self._state_sequence, self._state = epoch, -1, None
        self._starts = self._starts_nearest
        self._foresight.restart()
        self._series.restart()
        self._schedule.restart()

    def _due(self, now_ns: int, state: PlantState) -> Sequence[int]:
        """Return the plant times for which this step makes inputs, and prepare for them."""
        target_ns = self._schedule.effective_ns(now_ns, state)
        first_ns, begins = self._series.begins_with(state, target_ns)
        if begins:
            self._foresight.begin(first_ns)
            self._starts = self._starts_nearest
        if first_ns == target_ns:
            return (target_ns,)
        last_ns = min(target_ns, first_ns + (MOST_AT_ONCE - 1) * self._period_ns)
        return range(first_ns, last_ns + 1, self._period_ns)

    def _decide(
        self,
        effective_ns: int,
        u_h: Vector,
        u_h_rate: Vector,
        operator_is_stale: bool,
        inbox: Sequence[Received],
        ages: tuple[int, int],
        outgoing: list[Outgoing],
    ) -> TickRecord:
        predicted = self._foresight.at(effective_ns)
        tank_j = predicted.tank_j
        starts = self._starts and predicted.phase is _WAITING  # a plant that moves has an input in force
        decision = self._core.decide(
            predicted.sample.x, predicted.u, u_h, u_h_rate, tank_j, effective_ns * 1e-9, start=starts
        )
        self._starts = False
        self._tick += 1
        self._foresight.sent(effective_ns, decision.u)
        outgoing.append((INPUT, self._series.message(self._tick, decision.u, effective_ns)))
        stale = operator_is_stale and not decision.status.is_fallback
        state_age_ns, command_age_ns = ages
        return TickRecord(
            self._telemetry,
            self._tick,
            _STALE if stale else STATUS[decision.status],
            decision,
            effective_ns,
            tank_j,
            inbox,
            state_age_ns,
            command_age_ns,
            self._foresight.horizon_ns,
        )

    def _introduce(self) -> list[Outgoing]:
        info, self._info = self._info, None
        return [] if info is None else [(SCENARIO, info)]
