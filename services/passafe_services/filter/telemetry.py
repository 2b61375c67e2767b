"""FilterTick: the complete record of a tick as a message."""

from collections.abc import Sequence
from typing import Final

from msgspec import Struct
from msgspec.structs import replace
from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    Consumed,
    FilterStatus,
    FilterTick,
    OverrideReport,
    Received,
    RowReport,
    Vector,
)
from passafe_protocol.topics import TOPIC_OF_BODY

from passafe.decision import Decision, Status
from passafe.decision_schema import Answer, Evaluation, Program, Request
from passafe.design import FilterDesign
from passafe.filter import SafetyPassivityFilter
from passafe.override import Explainer
from passafe.program.infeasibility import DistanceToInfeasibility
from passafe_services.filter.member_rows import BarrierMembers, barrier_members
from passafe_services.filter.operator_request import OperatorRequest

_BY_VALUE: Final = {status.value: FilterStatus[status.name] for status in Status}

STATUS: Final = tuple(_BY_VALUE.get(value, FilterStatus.UNCERTIFIED) for value in range(max(_BY_VALUE) + 1))
"""Status on the wire by the value of the core's status; a table, because hashing a member costs 0.4 µs."""


class TickRecord(Struct, frozen=True, eq=False, gc=False):
    """Data of a tick message, which is computed only on demand.

    Attributes:
        telemetry: Computes the message.
        tick: Number of the tick.
        status: Status, staleness included.
        decision: The decision.
        basis: The decision whose distance to infeasibility is reported.
        effective_plant_ns: Plant time at which the decision takes effect, ns.
        tank_j: Predicted energy in the tank at that time, J.
        inbox: Messages that the step consumed.
        state_age_ns: Age of the newest state, ns; −1 before the first one.
        request: The operator's request.
        horizon_ns: Prediction horizon, ns.
        residual: Newest state against what the scenario's sets allow, n factors; empty without.
    """

    telemetry: "Telemetry"
    tick: int
    status: FilterStatus
    decision: Decision
    basis: Decision
    effective_plant_ns: int
    tank_j: float
    inbox: Sequence[Received]
    state_age_ns: int
    request: OperatorRequest
    horizon_ns: int
    residual: Vector = ()

    def for_step(
        self, status: FilterStatus, inbox: Sequence[Received], state_age_ns: int, request: OperatorRequest
    ) -> "TickRecord":
        """Return the record of a step without a new decision."""
        return replace(self, status=status, inbox=inbox, state_age_ns=state_age_ns, request=request)

    def __call__(self) -> FilterTick:
        """Return the message."""
        return self.telemetry.message(self)


class Telemetry:
    """Converts tick records into messages."""

    def __init__(self, core: SafetyPassivityFilter, explainer: Explainer) -> None:
        self._design: FilterDesign = core.design
        self._row_names = core.row_names
        self._constraints = core.constraints
        self._explainer = explainer
        self._hard = core.derivation.rows.hard
        self._distance = DistanceToInfeasibility(core.design.limits, self._hard)
        self._newest_distance: tuple[Decision, float] | None = None
        self._has_eps = bool(core.layout.shapes["eps"][0])
        self._chains = len(core.chains)
        self._barriers = barrier_members(core)

    def message(self, record: TickRecord) -> FilterTick:
        """Return the message of one tick."""
        decision = record.decision
        numbers, parts = decision.block.tolist(), decision.layout.parts

        def vector(name: str) -> tuple[float, ...]:
            return tuple(numbers[parts[name]])

        request, program = Request.of(vector), Program.of(vector)
        answer, evaluation = Answer.of(vector), Evaluation.of(vector)
        eps = evaluation.eps if self._has_eps else (0.0,) * self._chains
        override = self._explainer.override(decision)
        shares = {cause.row: cause.share for cause in override.causes}
        relaxed = (*answer.relax, *(0.0,) * (len(self._row_names) - self._hard))
        return FilterTick(
            tick=record.tick,
            status=record.status,
            mode=self._design.mode.value,
            law=self._design.law.value,
            effective_plant_ns=record.effective_plant_ns,
            x_hat=request.x,
            u_h=request.u_h,
            u_h_rate=request.u_h_rate,
            u_nominal=program.u_nominal,
            phi=program.phi,
            v=evaluation.v,
            u=decision.u,
            barriers=tuple(_barrier_report(members, evaluation.psi, eps) for members in self._barriers),
            power_margin=decision.power_margin,
            tank_j=record.tank_j,
            slack=decision.slack,
            rows=tuple(
                RowReport(name, margin, dual, name in shares, shares.get(name, 0.0), less)
                for i, (name, margin, dual, less) in enumerate(
                    zip(self._row_names, evaluation.margins, answer.lam, relaxed, strict=True)
                )
                if i < self._constraints or name in shares  # limits only if they are active
            ),
            certificate=Certificate(
                decision.solver,
                decision.status.is_certified,
                decision.primal_residual,
                decision.dual_residual,
                decision.gap,
            ),
            consumed=tuple(
                Consumed(TOPIC_OF_BODY[type(r.body)].name, r.header.sequence, r.received_ns, r.header.epoch, r.term)
                for r in record.inbox
            ),
            state_age_ns=record.state_age_ns,
            command_age_ns=record.request.age_ns,
            override=OverrideReport(
                tuple(override.held_back.tolist()),
                override.allowed_fraction,
                override.unavoidable,
                self._distance_at(record.basis),
            ),
            horizon_ns=record.horizon_ns,
            command_state=record.request.state.value,
            command_share=record.request.share,
            x_error=request.x_error,
            residual=record.residual,
        )

    def _distance_at(self, basis: Decision) -> float:
        """Return the distance to infeasibility at a decision; of the newest one it is computed once."""
        if self._newest_distance is None or self._newest_distance[0] is not basis:
            self._newest_distance = basis, self._distance.of(basis).lower
        return self._newest_distance[1]


def _barrier_report(members: BarrierMembers, psi: Vector, eps: Vector) -> BarrierReport:
    """Return the report of a barrier: of several members the lowest values, and the largest margin."""
    if len(members.places) == 1:
        return BarrierReport(members.name, psi[members.places[0]], eps[members.chains[0]])
    lowest = tuple(map(min, *(psi[place] for place in members.places)))
    return BarrierReport(members.name, lowest, max(eps[number] for number in members.chains))
