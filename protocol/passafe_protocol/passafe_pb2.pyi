from google.protobuf.internal import containers as _containers
from google.protobuf.internal import enum_type_wrapper as _enum_type_wrapper
from google.protobuf import descriptor as _descriptor
from google.protobuf import message as _message
from collections.abc import Iterable as _Iterable, Mapping as _Mapping
from typing import ClassVar as _ClassVar, Optional as _Optional, Union as _Union

DESCRIPTOR: _descriptor.FileDescriptor

class PlantPhase(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    PLANT_PHASE_UNSPECIFIED: _ClassVar[PlantPhase]
    WAITING: _ClassVar[PlantPhase]
    RUNNING: _ClassVar[PlantPhase]
    HOLDING: _ClassVar[PlantPhase]
    FAIL_SAFE: _ClassVar[PlantPhase]

class FilterStatus(int, metaclass=_enum_type_wrapper.EnumTypeWrapper):
    __slots__ = ()
    FILTER_STATUS_UNSPECIFIED: _ClassVar[FilterStatus]
    PASSED: _ClassVar[FilterStatus]
    MODIFIED: _ClassVar[FilterStatus]
    RELAXED: _ClassVar[FilterStatus]
    UNCERTIFIED: _ClassVar[FilterStatus]
    INFEASIBLE: _ClassVar[FilterStatus]
    STALE: _ClassVar[FilterStatus]
    AT_SAMPLES: _ClassVar[FilterStatus]
    BACKUP: _ClassVar[FilterStatus]
    STOPPED: _ClassVar[FilterStatus]
PLANT_PHASE_UNSPECIFIED: PlantPhase
WAITING: PlantPhase
RUNNING: PlantPhase
HOLDING: PlantPhase
FAIL_SAFE: PlantPhase
FILTER_STATUS_UNSPECIFIED: FilterStatus
PASSED: FilterStatus
MODIFIED: FilterStatus
RELAXED: FilterStatus
UNCERTIFIED: FilterStatus
INFEASIBLE: FilterStatus
STALE: FilterStatus
AT_SAMPLES: FilterStatus
BACKUP: FilterStatus
STOPPED: FilterStatus

class Header(_message.Message):
    __slots__ = ("schema_version", "source", "epoch", "sequence", "scheduled_ns", "started_ns", "sent_ns", "wall_ns", "clock_id")
    SCHEMA_VERSION_FIELD_NUMBER: _ClassVar[int]
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    SCHEDULED_NS_FIELD_NUMBER: _ClassVar[int]
    STARTED_NS_FIELD_NUMBER: _ClassVar[int]
    SENT_NS_FIELD_NUMBER: _ClassVar[int]
    WALL_NS_FIELD_NUMBER: _ClassVar[int]
    CLOCK_ID_FIELD_NUMBER: _ClassVar[int]
    schema_version: int
    source: str
    epoch: int
    sequence: int
    scheduled_ns: int
    started_ns: int
    sent_ns: int
    wall_ns: int
    clock_id: int
    def __init__(self, schema_version: _Optional[int] = ..., source: _Optional[str] = ..., epoch: _Optional[int] = ..., sequence: _Optional[int] = ..., scheduled_ns: _Optional[int] = ..., started_ns: _Optional[int] = ..., sent_ns: _Optional[int] = ..., wall_ns: _Optional[int] = ..., clock_id: _Optional[int] = ...) -> None: ...

class OperatorCommand(_message.Message):
    __slots__ = ("header", "u_h", "u_h_rate", "enabled", "device", "echoed_epoch", "echoed_ns", "echoed_for_ns", "take_over", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    U_H_FIELD_NUMBER: _ClassVar[int]
    U_H_RATE_FIELD_NUMBER: _ClassVar[int]
    ENABLED_FIELD_NUMBER: _ClassVar[int]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    ECHOED_EPOCH_FIELD_NUMBER: _ClassVar[int]
    ECHOED_NS_FIELD_NUMBER: _ClassVar[int]
    ECHOED_FOR_NS_FIELD_NUMBER: _ClassVar[int]
    TAKE_OVER_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    u_h: _containers.RepeatedScalarFieldContainer[float]
    u_h_rate: _containers.RepeatedScalarFieldContainer[float]
    enabled: bool
    device: str
    echoed_epoch: int
    echoed_ns: int
    echoed_for_ns: int
    take_over: int
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., u_h: _Optional[_Iterable[float]] = ..., u_h_rate: _Optional[_Iterable[float]] = ..., enabled: _Optional[bool] = ..., device: _Optional[str] = ..., echoed_epoch: _Optional[int] = ..., echoed_ns: _Optional[int] = ..., echoed_for_ns: _Optional[int] = ..., take_over: _Optional[int] = ..., checksum: _Optional[int] = ...) -> None: ...

class PlantInput(_message.Message):
    __slots__ = ("header", "tick", "u", "effective_plant_ns", "hold_ns", "input_sequence_start_ns", "known_break_ns", "previous_u", "stops_cleared", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    EFFECTIVE_PLANT_NS_FIELD_NUMBER: _ClassVar[int]
    HOLD_NS_FIELD_NUMBER: _ClassVar[int]
    INPUT_SEQUENCE_START_NS_FIELD_NUMBER: _ClassVar[int]
    KNOWN_BREAK_NS_FIELD_NUMBER: _ClassVar[int]
    PREVIOUS_U_FIELD_NUMBER: _ClassVar[int]
    STOPS_CLEARED_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    tick: int
    u: _containers.RepeatedScalarFieldContainer[float]
    effective_plant_ns: int
    hold_ns: int
    input_sequence_start_ns: int
    known_break_ns: int
    previous_u: _containers.RepeatedScalarFieldContainer[float]
    stops_cleared: int
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., tick: _Optional[int] = ..., u: _Optional[_Iterable[float]] = ..., effective_plant_ns: _Optional[int] = ..., hold_ns: _Optional[int] = ..., input_sequence_start_ns: _Optional[int] = ..., known_break_ns: _Optional[int] = ..., previous_u: _Optional[_Iterable[float]] = ..., stops_cleared: _Optional[int] = ..., checksum: _Optional[int] = ...) -> None: ...

class PlantState(_message.Message):
    __slots__ = ("header", "plant_ns", "x", "y", "u", "applied_tick", "phase", "energy_in_j", "energy_stored_j", "input_lead_ns", "inputs_late", "inputs_refused", "integration_error", "received_tick", "sequence_break_ns", "input_since_ns", "input_transit_ns", "input_epoch", "stop", "stop_source", "stops_cleared", "guard", "u_asked", "guard_cause", "guarded", "true_x", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PLANT_NS_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    APPLIED_TICK_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    ENERGY_IN_J_FIELD_NUMBER: _ClassVar[int]
    ENERGY_STORED_J_FIELD_NUMBER: _ClassVar[int]
    INPUT_LEAD_NS_FIELD_NUMBER: _ClassVar[int]
    INPUTS_LATE_FIELD_NUMBER: _ClassVar[int]
    INPUTS_REFUSED_FIELD_NUMBER: _ClassVar[int]
    INTEGRATION_ERROR_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_TICK_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_BREAK_NS_FIELD_NUMBER: _ClassVar[int]
    INPUT_SINCE_NS_FIELD_NUMBER: _ClassVar[int]
    INPUT_TRANSIT_NS_FIELD_NUMBER: _ClassVar[int]
    INPUT_EPOCH_FIELD_NUMBER: _ClassVar[int]
    STOP_FIELD_NUMBER: _ClassVar[int]
    STOP_SOURCE_FIELD_NUMBER: _ClassVar[int]
    STOPS_CLEARED_FIELD_NUMBER: _ClassVar[int]
    GUARD_FIELD_NUMBER: _ClassVar[int]
    U_ASKED_FIELD_NUMBER: _ClassVar[int]
    GUARD_CAUSE_FIELD_NUMBER: _ClassVar[int]
    GUARDED_FIELD_NUMBER: _ClassVar[int]
    TRUE_X_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    plant_ns: int
    x: _containers.RepeatedScalarFieldContainer[float]
    y: _containers.RepeatedScalarFieldContainer[float]
    u: _containers.RepeatedScalarFieldContainer[float]
    applied_tick: int
    phase: PlantPhase
    energy_in_j: float
    energy_stored_j: float
    input_lead_ns: int
    inputs_late: int
    inputs_refused: int
    integration_error: float
    received_tick: int
    sequence_break_ns: int
    input_since_ns: int
    input_transit_ns: int
    input_epoch: int
    stop: int
    stop_source: str
    stops_cleared: int
    guard: str
    u_asked: _containers.RepeatedScalarFieldContainer[float]
    guard_cause: str
    guarded: int
    true_x: _containers.RepeatedScalarFieldContainer[float]
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., plant_ns: _Optional[int] = ..., x: _Optional[_Iterable[float]] = ..., y: _Optional[_Iterable[float]] = ..., u: _Optional[_Iterable[float]] = ..., applied_tick: _Optional[int] = ..., phase: _Optional[_Union[PlantPhase, str]] = ..., energy_in_j: _Optional[float] = ..., energy_stored_j: _Optional[float] = ..., input_lead_ns: _Optional[int] = ..., inputs_late: _Optional[int] = ..., inputs_refused: _Optional[int] = ..., integration_error: _Optional[float] = ..., received_tick: _Optional[int] = ..., sequence_break_ns: _Optional[int] = ..., input_since_ns: _Optional[int] = ..., input_transit_ns: _Optional[int] = ..., input_epoch: _Optional[int] = ..., stop: _Optional[int] = ..., stop_source: _Optional[str] = ..., stops_cleared: _Optional[int] = ..., guard: _Optional[str] = ..., u_asked: _Optional[_Iterable[float]] = ..., guard_cause: _Optional[str] = ..., guarded: _Optional[int] = ..., true_x: _Optional[_Iterable[float]] = ..., checksum: _Optional[int] = ...) -> None: ...

class Steer(_message.Message):
    __slots__ = ("header", "turn", "driver", "page", "shares", "engaged", "age_ns", "take_over", "echoed_epoch", "echoed_ns", "echoed_for_ns", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TURN_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    PAGE_FIELD_NUMBER: _ClassVar[int]
    SHARES_FIELD_NUMBER: _ClassVar[int]
    ENGAGED_FIELD_NUMBER: _ClassVar[int]
    AGE_NS_FIELD_NUMBER: _ClassVar[int]
    TAKE_OVER_FIELD_NUMBER: _ClassVar[int]
    ECHOED_EPOCH_FIELD_NUMBER: _ClassVar[int]
    ECHOED_NS_FIELD_NUMBER: _ClassVar[int]
    ECHOED_FOR_NS_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    turn: int
    driver: str
    page: int
    shares: _containers.RepeatedScalarFieldContainer[float]
    engaged: bool
    age_ns: int
    take_over: bool
    echoed_epoch: int
    echoed_ns: int
    echoed_for_ns: int
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., turn: _Optional[int] = ..., driver: _Optional[str] = ..., page: _Optional[int] = ..., shares: _Optional[_Iterable[float]] = ..., engaged: _Optional[bool] = ..., age_ns: _Optional[int] = ..., take_over: _Optional[bool] = ..., echoed_epoch: _Optional[int] = ..., echoed_ns: _Optional[int] = ..., echoed_for_ns: _Optional[int] = ..., checksum: _Optional[int] = ...) -> None: ...

class EmergencyStop(_message.Message):
    __slots__ = ("header", "id", "reason", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    ID_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    id: int
    reason: str
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., id: _Optional[int] = ..., reason: _Optional[str] = ..., checksum: _Optional[int] = ...) -> None: ...

class StopClear(_message.Message):
    __slots__ = ("header", "stop", "reason", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    STOP_FIELD_NUMBER: _ClassVar[int]
    REASON_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    stop: int
    reason: str
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., stop: _Optional[int] = ..., reason: _Optional[str] = ..., checksum: _Optional[int] = ...) -> None: ...

class OperatorLease(_message.Message):
    __slots__ = ("header", "number", "holder", "device", "command_age_ns", "refused", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    HOLDER_FIELD_NUMBER: _ClassVar[int]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    COMMAND_AGE_NS_FIELD_NUMBER: _ClassVar[int]
    REFUSED_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    number: int
    holder: int
    device: str
    command_age_ns: int
    refused: int
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., number: _Optional[int] = ..., holder: _Optional[int] = ..., device: _Optional[str] = ..., command_age_ns: _Optional[int] = ..., refused: _Optional[int] = ..., checksum: _Optional[int] = ...) -> None: ...

class BarrierReport(_message.Message):
    __slots__ = ("name", "psi", "eps")
    NAME_FIELD_NUMBER: _ClassVar[int]
    PSI_FIELD_NUMBER: _ClassVar[int]
    EPS_FIELD_NUMBER: _ClassVar[int]
    name: str
    psi: _containers.RepeatedScalarFieldContainer[float]
    eps: float
    def __init__(self, name: _Optional[str] = ..., psi: _Optional[_Iterable[float]] = ..., eps: _Optional[float] = ...) -> None: ...

class RowReport(_message.Message):
    __slots__ = ("name", "margin", "dual", "active", "share", "relaxed")
    NAME_FIELD_NUMBER: _ClassVar[int]
    MARGIN_FIELD_NUMBER: _ClassVar[int]
    DUAL_FIELD_NUMBER: _ClassVar[int]
    ACTIVE_FIELD_NUMBER: _ClassVar[int]
    SHARE_FIELD_NUMBER: _ClassVar[int]
    RELAXED_FIELD_NUMBER: _ClassVar[int]
    name: str
    margin: float
    dual: float
    active: bool
    share: float
    relaxed: float
    def __init__(self, name: _Optional[str] = ..., margin: _Optional[float] = ..., dual: _Optional[float] = ..., active: _Optional[bool] = ..., share: _Optional[float] = ..., relaxed: _Optional[float] = ...) -> None: ...

class OverrideReport(_message.Message):
    __slots__ = ("held_back", "allowed_fraction", "unavoidable", "distance_to_infeasibility")
    HELD_BACK_FIELD_NUMBER: _ClassVar[int]
    ALLOWED_FRACTION_FIELD_NUMBER: _ClassVar[int]
    UNAVOIDABLE_FIELD_NUMBER: _ClassVar[int]
    DISTANCE_TO_INFEASIBILITY_FIELD_NUMBER: _ClassVar[int]
    held_back: _containers.RepeatedScalarFieldContainer[float]
    allowed_fraction: float
    unavoidable: bool
    distance_to_infeasibility: float
    def __init__(self, held_back: _Optional[_Iterable[float]] = ..., allowed_fraction: _Optional[float] = ..., unavoidable: _Optional[bool] = ..., distance_to_infeasibility: _Optional[float] = ...) -> None: ...

class Certificate(_message.Message):
    __slots__ = ("solver", "accepted", "primal_residual", "dual_residual", "gap")
    SOLVER_FIELD_NUMBER: _ClassVar[int]
    ACCEPTED_FIELD_NUMBER: _ClassVar[int]
    PRIMAL_RESIDUAL_FIELD_NUMBER: _ClassVar[int]
    DUAL_RESIDUAL_FIELD_NUMBER: _ClassVar[int]
    GAP_FIELD_NUMBER: _ClassVar[int]
    solver: str
    accepted: bool
    primal_residual: float
    dual_residual: float
    gap: float
    def __init__(self, solver: _Optional[str] = ..., accepted: _Optional[bool] = ..., primal_residual: _Optional[float] = ..., dual_residual: _Optional[float] = ..., gap: _Optional[float] = ...) -> None: ...

class Consumed(_message.Message):
    __slots__ = ("topic", "sequence", "received_ns", "epoch", "term")
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_NS_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    TERM_FIELD_NUMBER: _ClassVar[int]
    topic: str
    sequence: int
    received_ns: int
    epoch: int
    term: int
    def __init__(self, topic: _Optional[str] = ..., sequence: _Optional[int] = ..., received_ns: _Optional[int] = ..., epoch: _Optional[int] = ..., term: _Optional[int] = ...) -> None: ...

class FilterTick(_message.Message):
    __slots__ = ("header", "tick", "status", "mode", "law", "effective_plant_ns", "x_hat", "u_h", "u_h_rate", "u_nominal", "phi", "v", "u", "barriers", "power_margin", "tank_j", "slack", "rows", "certificate", "consumed", "state_age_ns", "command_age_ns", "override", "horizon_ns", "command_state", "command_share", "x_error", "residual", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    STATUS_FIELD_NUMBER: _ClassVar[int]
    MODE_FIELD_NUMBER: _ClassVar[int]
    LAW_FIELD_NUMBER: _ClassVar[int]
    EFFECTIVE_PLANT_NS_FIELD_NUMBER: _ClassVar[int]
    X_HAT_FIELD_NUMBER: _ClassVar[int]
    U_H_FIELD_NUMBER: _ClassVar[int]
    U_H_RATE_FIELD_NUMBER: _ClassVar[int]
    U_NOMINAL_FIELD_NUMBER: _ClassVar[int]
    PHI_FIELD_NUMBER: _ClassVar[int]
    V_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    BARRIERS_FIELD_NUMBER: _ClassVar[int]
    POWER_MARGIN_FIELD_NUMBER: _ClassVar[int]
    TANK_J_FIELD_NUMBER: _ClassVar[int]
    SLACK_FIELD_NUMBER: _ClassVar[int]
    ROWS_FIELD_NUMBER: _ClassVar[int]
    CERTIFICATE_FIELD_NUMBER: _ClassVar[int]
    CONSUMED_FIELD_NUMBER: _ClassVar[int]
    STATE_AGE_NS_FIELD_NUMBER: _ClassVar[int]
    COMMAND_AGE_NS_FIELD_NUMBER: _ClassVar[int]
    OVERRIDE_FIELD_NUMBER: _ClassVar[int]
    HORIZON_NS_FIELD_NUMBER: _ClassVar[int]
    COMMAND_STATE_FIELD_NUMBER: _ClassVar[int]
    COMMAND_SHARE_FIELD_NUMBER: _ClassVar[int]
    X_ERROR_FIELD_NUMBER: _ClassVar[int]
    RESIDUAL_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    tick: int
    status: FilterStatus
    mode: str
    law: str
    effective_plant_ns: int
    x_hat: _containers.RepeatedScalarFieldContainer[float]
    u_h: _containers.RepeatedScalarFieldContainer[float]
    u_h_rate: _containers.RepeatedScalarFieldContainer[float]
    u_nominal: _containers.RepeatedScalarFieldContainer[float]
    phi: _containers.RepeatedScalarFieldContainer[float]
    v: _containers.RepeatedScalarFieldContainer[float]
    u: _containers.RepeatedScalarFieldContainer[float]
    barriers: _containers.RepeatedCompositeFieldContainer[BarrierReport]
    power_margin: float
    tank_j: float
    slack: float
    rows: _containers.RepeatedCompositeFieldContainer[RowReport]
    certificate: Certificate
    consumed: _containers.RepeatedCompositeFieldContainer[Consumed]
    state_age_ns: int
    command_age_ns: int
    override: OverrideReport
    horizon_ns: int
    command_state: str
    command_share: float
    x_error: _containers.RepeatedScalarFieldContainer[float]
    residual: _containers.RepeatedScalarFieldContainer[float]
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., tick: _Optional[int] = ..., status: _Optional[_Union[FilterStatus, str]] = ..., mode: _Optional[str] = ..., law: _Optional[str] = ..., effective_plant_ns: _Optional[int] = ..., x_hat: _Optional[_Iterable[float]] = ..., u_h: _Optional[_Iterable[float]] = ..., u_h_rate: _Optional[_Iterable[float]] = ..., u_nominal: _Optional[_Iterable[float]] = ..., phi: _Optional[_Iterable[float]] = ..., v: _Optional[_Iterable[float]] = ..., u: _Optional[_Iterable[float]] = ..., barriers: _Optional[_Iterable[_Union[BarrierReport, _Mapping]]] = ..., power_margin: _Optional[float] = ..., tank_j: _Optional[float] = ..., slack: _Optional[float] = ..., rows: _Optional[_Iterable[_Union[RowReport, _Mapping]]] = ..., certificate: _Optional[_Union[Certificate, _Mapping]] = ..., consumed: _Optional[_Iterable[_Union[Consumed, _Mapping]]] = ..., state_age_ns: _Optional[int] = ..., command_age_ns: _Optional[int] = ..., override: _Optional[_Union[OverrideReport, _Mapping]] = ..., horizon_ns: _Optional[int] = ..., command_state: _Optional[str] = ..., command_share: _Optional[float] = ..., x_error: _Optional[_Iterable[float]] = ..., residual: _Optional[_Iterable[float]] = ..., checksum: _Optional[int] = ...) -> None: ...

class LinkParameters(_message.Message):
    __slots__ = ("delay_s", "jitter_s", "distribution", "quantiles_s", "correlation", "reorder", "loss", "burst_enter", "burst_leave", "burst_loss_good", "burst_loss_bad", "duplicate", "corrupt", "rate_hz", "queue", "outages", "seed", "network")
    DELAY_S_FIELD_NUMBER: _ClassVar[int]
    JITTER_S_FIELD_NUMBER: _ClassVar[int]
    DISTRIBUTION_FIELD_NUMBER: _ClassVar[int]
    QUANTILES_S_FIELD_NUMBER: _ClassVar[int]
    CORRELATION_FIELD_NUMBER: _ClassVar[int]
    REORDER_FIELD_NUMBER: _ClassVar[int]
    LOSS_FIELD_NUMBER: _ClassVar[int]
    BURST_ENTER_FIELD_NUMBER: _ClassVar[int]
    BURST_LEAVE_FIELD_NUMBER: _ClassVar[int]
    BURST_LOSS_GOOD_FIELD_NUMBER: _ClassVar[int]
    BURST_LOSS_BAD_FIELD_NUMBER: _ClassVar[int]
    DUPLICATE_FIELD_NUMBER: _ClassVar[int]
    CORRUPT_FIELD_NUMBER: _ClassVar[int]
    RATE_HZ_FIELD_NUMBER: _ClassVar[int]
    QUEUE_FIELD_NUMBER: _ClassVar[int]
    OUTAGES_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    NETWORK_FIELD_NUMBER: _ClassVar[int]
    delay_s: float
    jitter_s: float
    distribution: str
    quantiles_s: _containers.RepeatedScalarFieldContainer[float]
    correlation: float
    reorder: bool
    loss: float
    burst_enter: float
    burst_leave: float
    burst_loss_good: float
    burst_loss_bad: float
    duplicate: float
    corrupt: float
    rate_hz: float
    queue: int
    outages: _containers.RepeatedCompositeFieldContainer[LinkOutage]
    seed: int
    network: str
    def __init__(self, delay_s: _Optional[float] = ..., jitter_s: _Optional[float] = ..., distribution: _Optional[str] = ..., quantiles_s: _Optional[_Iterable[float]] = ..., correlation: _Optional[float] = ..., reorder: _Optional[bool] = ..., loss: _Optional[float] = ..., burst_enter: _Optional[float] = ..., burst_leave: _Optional[float] = ..., burst_loss_good: _Optional[float] = ..., burst_loss_bad: _Optional[float] = ..., duplicate: _Optional[float] = ..., corrupt: _Optional[float] = ..., rate_hz: _Optional[float] = ..., queue: _Optional[int] = ..., outages: _Optional[_Iterable[_Union[LinkOutage, _Mapping]]] = ..., seed: _Optional[int] = ..., network: _Optional[str] = ...) -> None: ...

class LinkOutage(_message.Message):
    __slots__ = ("start_s", "end_s")
    START_S_FIELD_NUMBER: _ClassVar[int]
    END_S_FIELD_NUMBER: _ClassVar[int]
    start_s: float
    end_s: float
    def __init__(self, start_s: _Optional[float] = ..., end_s: _Optional[float] = ...) -> None: ...

class LinkConfig(_message.Message):
    __slots__ = ("header", "link", "parameters", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LINK_FIELD_NUMBER: _ClassVar[int]
    PARAMETERS_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    link: str
    parameters: LinkParameters
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., link: _Optional[str] = ..., parameters: _Optional[_Union[LinkParameters, _Mapping]] = ..., checksum: _Optional[int] = ...) -> None: ...

class LinkEvent(_message.Message):
    __slots__ = ("header", "link", "effect", "topic", "sequence", "cause", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LINK_FIELD_NUMBER: _ClassVar[int]
    EFFECT_FIELD_NUMBER: _ClassVar[int]
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    CAUSE_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    link: str
    effect: str
    topic: str
    sequence: int
    cause: str
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., link: _Optional[str] = ..., effect: _Optional[str] = ..., topic: _Optional[str] = ..., sequence: _Optional[int] = ..., cause: _Optional[str] = ..., checksum: _Optional[int] = ...) -> None: ...

class LinkState(_message.Message):
    __slots__ = ("header", "link", "topic", "parameters", "trace_opportunities", "entered", "delivered", "dropped_loss", "dropped_queue", "dropped_outage", "duplicated", "corrupted", "in_flight", "refused_corrupted", "refused_duplicate", "trigger", "config_source", "config_epoch", "config_sequence", "refusal", "sources", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LINK_FIELD_NUMBER: _ClassVar[int]
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    PARAMETERS_FIELD_NUMBER: _ClassVar[int]
    TRACE_OPPORTUNITIES_FIELD_NUMBER: _ClassVar[int]
    ENTERED_FIELD_NUMBER: _ClassVar[int]
    DELIVERED_FIELD_NUMBER: _ClassVar[int]
    DROPPED_LOSS_FIELD_NUMBER: _ClassVar[int]
    DROPPED_QUEUE_FIELD_NUMBER: _ClassVar[int]
    DROPPED_OUTAGE_FIELD_NUMBER: _ClassVar[int]
    DUPLICATED_FIELD_NUMBER: _ClassVar[int]
    CORRUPTED_FIELD_NUMBER: _ClassVar[int]
    IN_FLIGHT_FIELD_NUMBER: _ClassVar[int]
    REFUSED_CORRUPTED_FIELD_NUMBER: _ClassVar[int]
    REFUSED_DUPLICATE_FIELD_NUMBER: _ClassVar[int]
    TRIGGER_FIELD_NUMBER: _ClassVar[int]
    CONFIG_SOURCE_FIELD_NUMBER: _ClassVar[int]
    CONFIG_EPOCH_FIELD_NUMBER: _ClassVar[int]
    CONFIG_SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    REFUSAL_FIELD_NUMBER: _ClassVar[int]
    SOURCES_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    link: str
    topic: str
    parameters: LinkParameters
    trace_opportunities: int
    entered: int
    delivered: int
    dropped_loss: int
    dropped_queue: int
    dropped_outage: int
    duplicated: int
    corrupted: int
    in_flight: int
    refused_corrupted: int
    refused_duplicate: int
    trigger: str
    config_source: str
    config_epoch: int
    config_sequence: int
    refusal: str
    sources: _containers.RepeatedCompositeFieldContainer[LinkSource]
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., link: _Optional[str] = ..., topic: _Optional[str] = ..., parameters: _Optional[_Union[LinkParameters, _Mapping]] = ..., trace_opportunities: _Optional[int] = ..., entered: _Optional[int] = ..., delivered: _Optional[int] = ..., dropped_loss: _Optional[int] = ..., dropped_queue: _Optional[int] = ..., dropped_outage: _Optional[int] = ..., duplicated: _Optional[int] = ..., corrupted: _Optional[int] = ..., in_flight: _Optional[int] = ..., refused_corrupted: _Optional[int] = ..., refused_duplicate: _Optional[int] = ..., trigger: _Optional[str] = ..., config_source: _Optional[str] = ..., config_epoch: _Optional[int] = ..., config_sequence: _Optional[int] = ..., refusal: _Optional[str] = ..., sources: _Optional[_Iterable[_Union[LinkSource, _Mapping]]] = ..., checksum: _Optional[int] = ...) -> None: ...

class LinkSource(_message.Message):
    __slots__ = ("source", "epoch", "first", "newest", "received")
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    FIRST_FIELD_NUMBER: _ClassVar[int]
    NEWEST_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_FIELD_NUMBER: _ClassVar[int]
    source: str
    epoch: int
    first: int
    newest: int
    received: int
    def __init__(self, source: _Optional[str] = ..., epoch: _Optional[int] = ..., first: _Optional[int] = ..., newest: _Optional[int] = ..., received: _Optional[int] = ...) -> None: ...

class Health(_message.Message):
    __slots__ = ("header", "rate_hz", "steps", "overruns", "steps_skipped", "late_us_max", "topics", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    RATE_HZ_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    OVERRUNS_FIELD_NUMBER: _ClassVar[int]
    STEPS_SKIPPED_FIELD_NUMBER: _ClassVar[int]
    LATE_US_MAX_FIELD_NUMBER: _ClassVar[int]
    TOPICS_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    rate_hz: float
    steps: int
    overruns: int
    steps_skipped: int
    late_us_max: float
    topics: _containers.RepeatedCompositeFieldContainer[TopicHealth]
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., rate_hz: _Optional[float] = ..., steps: _Optional[int] = ..., overruns: _Optional[int] = ..., steps_skipped: _Optional[int] = ..., late_us_max: _Optional[float] = ..., topics: _Optional[_Iterable[_Union[TopicHealth, _Mapping]]] = ..., checksum: _Optional[int] = ...) -> None: ...

class TopicHealth(_message.Message):
    __slots__ = ("topic", "received", "gaps", "refused")
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_FIELD_NUMBER: _ClassVar[int]
    GAPS_FIELD_NUMBER: _ClassVar[int]
    REFUSED_FIELD_NUMBER: _ClassVar[int]
    topic: str
    received: int
    gaps: int
    refused: int
    def __init__(self, topic: _Optional[str] = ..., received: _Optional[int] = ..., gaps: _Optional[int] = ..., refused: _Optional[int] = ...) -> None: ...

class Receipt(_message.Message):
    __slots__ = ("header", "sessions", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SESSIONS_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    sessions: _containers.RepeatedCompositeFieldContainer[RecordedSession]
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., sessions: _Optional[_Iterable[_Union[RecordedSession, _Mapping]]] = ..., checksum: _Optional[int] = ...) -> None: ...

class RecordedSession(_message.Message):
    __slots__ = ("source", "topic", "epoch", "newest")
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    NEWEST_FIELD_NUMBER: _ClassVar[int]
    source: str
    topic: str
    epoch: int
    newest: int
    def __init__(self, source: _Optional[str] = ..., topic: _Optional[str] = ..., epoch: _Optional[int] = ..., newest: _Optional[int] = ...) -> None: ...

class Event(_message.Message):
    __slots__ = ("header", "severity", "text", "kind", "number", "axis", "factor", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SEVERITY_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    KIND_FIELD_NUMBER: _ClassVar[int]
    NUMBER_FIELD_NUMBER: _ClassVar[int]
    AXIS_FIELD_NUMBER: _ClassVar[int]
    FACTOR_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    severity: str
    text: str
    kind: str
    number: int
    axis: str
    factor: float
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., severity: _Optional[str] = ..., text: _Optional[str] = ..., kind: _Optional[str] = ..., number: _Optional[int] = ..., axis: _Optional[str] = ..., factor: _Optional[float] = ..., checksum: _Optional[int] = ...) -> None: ...

class ScenarioInfo(_message.Message):
    __slots__ = ("header", "scenario_json", "driver", "versions_json", "checksum")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SCENARIO_JSON_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    VERSIONS_JSON_FIELD_NUMBER: _ClassVar[int]
    CHECKSUM_FIELD_NUMBER: _ClassVar[int]
    header: Header
    scenario_json: str
    driver: str
    versions_json: str
    checksum: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., scenario_json: _Optional[str] = ..., driver: _Optional[str] = ..., versions_json: _Optional[str] = ..., checksum: _Optional[int] = ...) -> None: ...
