"""Step of a filter node, with or without prediction: receive, decide for every due period, report."""

from collections.abc import Sequence
from typing import Final

from passafe_protocol.messages import (
    FilterStatus,
    OperatorCommand,
    PlantPhase,
    PlantState,
    Received,
    ScenarioInfo,
)
from passafe_protocol.topics import EVENT, INPUT, SCENARIO, TICK

from passafe.filter import SafetyPassivityFilter
from passafe.override import Explainer
from passafe_services.filter.command_intake import CommandIntake
from passafe_services.filter.distance_basis import DistanceBasis
from passafe_services.filter.event_emitter import OverrideEventEmitter, StatusEventEmitter
from passafe_services.filter.input_path import InputPath
from passafe_services.filter.model_watch import ModelWatch
from passafe_services.filter.newest_state import NewestState
from passafe_services.filter.operator_request import OperatorRequest
from passafe_services.filter.override_text import OverrideText
from passafe_services.filter.plant_clock import PlantClock
from passafe_services.filter.playout_schedule import PlayoutSchedule
from passafe_services.filter.send_time import SendTime
from passafe_services.filter.task_map import CommandMap
from passafe_services.filter.telemetry import STATUS, Telemetry, TickRecord
from passafe_services.node import Outgoing

_STALE: Final = FilterStatus.STALE
_STOPPED: Final = FilterStatus.STOPPED
_WAITING: Final = PlantPhase.WAITING

MOST_AT_ONCE: Final = 64
"""Largest number of inputs in one step, if the schedule moved forward."""

MOST_UNREPORTED: Final = 256
"""Largest number of messages listed in the first tick: 3000 take 8 ms, which delays the input."""


class DecisionLoop:
    """Executes the steps of a filter node: reads its inbox, decides and certifies, and reports."""

    def __init__(
        self,
        core: SafetyPassivityFilter,
        *,
        period_ns: int,
        schedule: PlayoutSchedule,
        commands: CommandIntake,
        command_map: CommandMap,
        plant_clock: PlantClock,
        clock_id: int,
        state_stale_ns: int,
        starts_nearest: bool,
        explainer: Explainer,
        override_text: OverrideText,
        info: ScenarioInfo,
        watch: ModelWatch | None = None,
    ) -> None:
        """Start with nothing received.

        Args:
            core: The filter.
            period_ns: Period of a step, ns.
            schedule: Assigns a plant time to every step.
            commands: Decides which commands count.
            command_map: Map from a command to u_h.
            plant_clock: Clock of the plant, which the commands' request knows as well.
            clock_id: Which monotonic clock the loop reads.
            state_stale_ns: Time without a newer state after which nothing is sent, ns.
            starts_nearest: Whether the very first input is the nearest to û, rather than one step from u = 0.
            explainer: Computes overrides and their causes.
            override_text: Describes an override in a sentence.
            info: Published in the first step.
            watch: Compares states with the scenario's sets, if it has any.
        """
        self._watch = watch
        self._uses_sets = core.design.uncertainty is not None
        self._core = core
        self._schedule = schedule
        self._telemetry = Telemetry(core, explainer)
        self._distance_basis = DistanceBasis()
        self._status_events = StatusEventEmitter()
        self._override_events = OverrideEventEmitter(explainer, override_text, max(core.design.limits.magnitude))
        self._commands = commands
        self._command_map = command_map
        self._plant_clock = plant_clock
        self._period_ns = period_ns
        self._state_stale_ns = state_stale_ns
        self._starts_nearest = self._starts = starts_nearest
        self._info: ScenarioInfo | None = info
        self._tick = 0
        self._newest = NewestState(core.design.system, SendTime(clock_id))
        self._last: TickRecord | None = None
        self._unreported: list[Received] = []

    def step(self, now_ns: int, inbox: Sequence[Received], path: InputPath) -> Sequence[Outgoing]:
        """Return the inputs for the plant and the record of each; nothing before the first plant state.

        There is one input per step, none while the state is stale, an emergency stop is latched or the schedule moves
        back, and several after it moved forward or steps were skipped.

        Args:
            now_ns: Time at which this step was due, monotonic, ns.
            inbox: Commands and states, in order of arrival.
            path: Prediction and sequencing of the node.
        """
        self._read(inbox, path)
        outgoing = self._commands.reports(now_ns)
        if self._info is not None:
            outgoing.insert(0, (SCENARIO, self._info))
            self._info = None
        state, state_age_ns = self._newest.state, self._newest.age_ns(now_ns)
        silence = self._silence(now_ns)
        effective = () if state is None or silence is not None else self._due(now_ns, state, path)
        if self._last is None:
            self._unreported += inbox
            if not effective:
                self._wait(path)
                return outgoing if state is None else [*outgoing, *self._status_event(now_ns, silence or _STALE)]
            inbox, self._unreported = self._unreported, []
        request = self._commands.at(now_ns)
        outgoing += self._commands.event(now_ns, request)
        for effective_ns in effective:
            self._last = self._decide(effective_ns, request, inbox, state_age_ns, path, outgoing)
            inbox = ()
            if now_ns >= self._override_events.check_due_ns:
                self._report_override(now_ns, self._last, outgoing)
            outgoing.append((TICK, self._last))
        last = self._last
        if last is None:
            return outgoing
        if self._watch is not None:
            outgoing += self._model_event(now_ns)
        status = last.status if silence is None else silence
        if status is not self._status_events.settled:
            outgoing += self._status_event(now_ns, status)
        if not effective:  # the last decision remains in force
            self._last = last = last.for_step(status, inbox, state_age_ns, request)
            outgoing.append((TICK, last))
        return outgoing

    def _read(self, inbox: Sequence[Received], path: InputPath) -> None:
        newest = self._newest
        for received in inbox:
            body = received.body
            if type(body) is PlantState:
                epoch = newest.epoch
                if newest.receive(received, body):
                    self._plant_clock.observe(received, body)
                    if newest.epoch != epoch:
                        self._start_plant_session(path)
                    if self._commands.observe(received.header, body):
                        path.void()
                    known = None if self._watch is None else self._watch.observe(body, path)
                    path.confirm(body, known if self._uses_sets else None)
            elif type(body) is OperatorCommand:
                self._commands.receive(received, body)

    def _silence(self, now_ns: int) -> FilterStatus | None:
        """Return the reason for which nothing is sent in this step; ``None`` if there is none."""
        if self._newest.state is None or self._newest.silence_ns(now_ns) > self._state_stale_ns:
            return _STALE
        return _STOPPED if self._commands.stop.is_stopped else None

    def _start_plant_session(self, path: InputPath) -> None:
        """Restart for a newer session of the plant."""
        self._starts = self._starts_nearest
        self._schedule.restart()
        path.restart()
        if self._watch is not None:
            self._watch.restart()

    def _wait(self, path: InputPath) -> None:
        """Keep received messages until the first tick lists them, so that replay is exact.

        A filter that waits for long, for a plant or for the end of another filter, restarts now and then.
        """
        self._schedule.restart()
        if len(self._unreported) > MOST_UNREPORTED:
            self._unreported = []
            self._commands.restart()
            self._newest.restart(0)
            self._start_plant_session(path)

    def _due(self, now_ns: int, state: PlantState, path: InputPath) -> Sequence[int]:
        """Return the plant times of this step's inputs."""
        target_ns = self._schedule.effective_ns(now_ns, state)
        first_ns, begins = path.next_input(state, target_ns)
        if begins:
            self._starts = self._starts_nearest
        if first_ns == target_ns:
            return (target_ns,)
        last_ns = min(target_ns, first_ns + (MOST_AT_ONCE - 1) * self._period_ns)
        return range(first_ns, last_ns + 1, self._period_ns)

    def _decide(
        self,
        effective_ns: int,
        request: OperatorRequest,
        inbox: Sequence[Received],
        state_age_ns: int,
        path: InputPath,
        outgoing: list[Outgoing],
    ) -> TickRecord:
        predicted = path.predict(effective_ns)
        tank_j = predicted.tank_j
        starts = self._starts and predicted.phase is _WAITING  # a moving plant has an input in force
        x, u = predicted.sample.x, predicted.u
        u_h, u_h_rate = self._command_map.inputs(x, u, request.u_h, request.u_h_rate)
        decision = self._core.decide(
            x, u, u_h, u_h_rate, tank_j, effective_ns * 1e-9, start=starts, x_error=predicted.x_error
        )
        self._starts = False
        self._tick += 1
        outgoing.append((INPUT, path.message(self._tick, decision.u, effective_ns, self._commands.stop.cleared)))
        stale = request.is_stale and not decision.status.is_fallback
        return TickRecord(
            self._telemetry,
            self._tick,
            _STALE if stale else STATUS[decision.status],
            decision,
            self._distance_basis.of(decision, effective_ns),
            effective_ns,
            tank_j,
            inbox,
            state_age_ns,
            request,
            path.horizon_ns,
            () if self._watch is None else self._watch.residual,
        )

    def _report_override(self, now_ns: int, record: TickRecord, outgoing: list[Outgoing]) -> None:
        event = self._override_events.event(now_ns, record.decision)
        if event is not None:
            outgoing.append((EVENT, event))

    def _status_event(self, now_ns: int, status: FilterStatus) -> list[Outgoing]:
        event = self._status_events.event(now_ns, status)
        return [] if event is None else [(EVENT, event)]

    def _model_event(self, now_ns: int) -> list[Outgoing]:
        event = None if self._watch is None else self._watch.event(now_ns)
        return [] if event is None else [(EVENT, event)]
