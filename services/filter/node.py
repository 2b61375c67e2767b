"""The filter process as a node: predicts, decides, certifies, and tells what it did."""

from collections.abc import Sequence

from passafe.decision import Decision
from passafe.filter import SafetyPassivityFilter
from passafe.override import Explainer
from passafe.sampled_plant import SampledPlant
from passafe.tank import Tank
from protocol.messages import (
    FilterStatus,
    OperatorCommand,
    PlantInput,
    PlantState,
    Received,
    ScenarioInfo,
    Vector,
)
from protocol.topics import COMMAND, EVENT, INPUT, SCENARIO, STATE, TICK, Topic
from services.filter.announcer import OverrideAnnouncer, StatusAnnouncer
from services.filter.prediction import Predictor
from services.filter.request import AsSent
from services.filter.schedule import EffectSchedule
from services.filter.telemetry import STATUS, Telemetry, TickRecord
from services.filter.wording import Wording
from services.runtime.node import Outgoing

_STALE = FilterStatus.STALE


class FilterNode:
    """Decides one input a step, for the plant time at which it will take effect.

    A command that is stale, released (dead-man) or of the wrong shape counts as u_h = 0; the rows are kept all the
    same. When the plant's state is stale nothing is sent at all: a prediction without states is no ground to act
    on, and the plant's own fail-safe takes over.

    Attributes:
        name: ``filter``.
        subscribes: Commands of the operator, states of the plant.
    """

    name = "filter"
    subscribes: tuple[Topic, ...] = (COMMAND, STATE)

    def __init__(
        self,
        core: SafetyPassivityFilter,
        plant: SampledPlant,
        tank: Tank,
        *,
        period_ns: int,
        playout_ns: int,
        hold_ns: int,
        request: AsSent,
        state_stale_ns: int,
        starts_nearest: bool,
        wording: Wording,
        info: ScenarioInfo,
    ) -> None:
        """Start with nothing heard.

        Args:
            core: The filter.
            plant: Model of the plant, for the prediction.
            tank: Energy ledger, reported in every mode.
            period_ns: Period of a step, ns.
            playout_ns: Play-out time of the plant, ns.
            hold_ns: How long the plant may hold an input, ns.
            request: What the operator's commands ask for.
            state_stale_ns: Age of the newest state from which nothing is sent, ns.
            starts_nearest: Whether the first input of all is the nearest to û, rather than one step from u = 0.
            wording: Puts what the filter overrides into words.
            info: Published by the first step.
        """
        system = core.design.system
        self._n, self._m = system.n, system.m
        self._core = core
        self._predictor = Predictor(plant, tank, period_ns)
        self._schedule = EffectSchedule(period_ns=period_ns, playout_ns=playout_ns)
        self._telemetry = Telemetry(core)
        self._announcer = StatusAnnouncer()
        self._overrides = OverrideAnnouncer(Explainer(core), wording, max(core.design.limits.magnitude))
        self._hold_ns = hold_ns
        self._hear, self._request = request.hear, request.at
        self._state_stale_ns = state_stale_ns
        self._starts = starts_nearest
        self._info: ScenarioInfo | None = info
        self._tick = 0
        self._state: PlantState | None = None
        self._state_ns = 0
        self._decision: Decision | None = None
        self._effective_ns = 0
        self._tank_j = tank.initial_j
        self._unaccounted: list[Received] = []

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the input for the plant and the account of the tick; nothing before the first plant state.

        Args:
            now_ns: When this step was due, monotonic, ns.
            inbox: Commands and states, in order of arrival.
        """
        self._read(inbox)
        outgoing = self._introduce()
        state = self._state
        if state is None:
            # The first tick accounts for what was consumed before it, so that a log can be stepped again.
            self._unaccounted += inbox
            return outgoing
        if self._unaccounted:
            inbox, self._unaccounted = [*self._unaccounted, *inbox], []
        self._tick += 1
        state_age_ns = now_ns - self._state_ns if now_ns > self._state_ns else 0
        u_h, u_h_rate, command_age_ns, operator_is_stale = self._request(now_ns)
        if state_age_ns > self._state_stale_ns:
            status = _STALE
        else:
            decision = self._decide(now_ns, state, u_h, u_h_rate)
            stale = operator_is_stale and not decision.status.is_fallback
            status = _STALE if stale else STATUS[decision.status]
            outgoing.append((INPUT, PlantInput(self._tick, decision.u, self._effective_ns, self._hold_ns)))
            if now_ns >= self._overrides.look_ns:
                overridden = self._overrides.event(now_ns, decision)
                if overridden is not None:
                    outgoing.append((EVENT, overridden))
        if status is not self._announcer.settled:
            event = self._announcer.event(now_ns, status)
            if event is not None:
                outgoing.append((EVENT, event))
        if self._decision is None:
            self._unaccounted += inbox
            return outgoing
        record = TickRecord(
            self._telemetry,
            self._tick,
            status,
            self._decision,
            self._effective_ns,
            self._tank_j,
            inbox,
            state_age_ns,
            command_age_ns,
        )
        outgoing.append((TICK, record))
        return outgoing

    def _read(self, inbox: Sequence[Received]) -> None:
        for received in inbox:
            body = received.body
            if type(body) is PlantState:
                newest = self._state
                if len(body.x) != self._n or not len(body.y) == len(body.u) == self._m:
                    continue  # not the plant of the filter's model
                if newest is None or body.plant_ns >= newest.plant_ns:
                    self._state, self._state_ns = body, received.received_ns
                    self._predictor.confirm(body)
            elif type(body) is OperatorCommand:
                self._hear(received, body)

    def _decide(self, now_ns: int, state: PlantState, u_h: Vector, u_h_rate: Vector) -> Decision:
        effective_ns = self._schedule.effective_ns(now_ns, state, self._tick)
        predicted = self._predictor.at(effective_ns)
        x, u, tank_j = predicted.sample.x, predicted.u, predicted.tank_j
        decision = self._core.decide(x, u, u_h, u_h_rate, tank_j, effective_ns * 1e-9, start=self._starts)
        self._starts = False
        self._predictor.sent(effective_ns, decision.u)
        self._decision, self._effective_ns, self._tank_j = decision, effective_ns, tank_j
        return decision

    def _introduce(self) -> list[Outgoing]:
        info, self._info = self._info, None
        return [] if info is None else [(SCENARIO, info)]
