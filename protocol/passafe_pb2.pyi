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
    STALE: _ClassVar[FilterStatus]
    UNCERTIFIED: _ClassVar[FilterStatus]
    INFEASIBLE: _ClassVar[FilterStatus]
PLANT_PHASE_UNSPECIFIED: PlantPhase
WAITING: PlantPhase
RUNNING: PlantPhase
HOLDING: PlantPhase
FAIL_SAFE: PlantPhase
FILTER_STATUS_UNSPECIFIED: FilterStatus
PASSED: FilterStatus
MODIFIED: FilterStatus
RELAXED: FilterStatus
STALE: FilterStatus
UNCERTIFIED: FilterStatus
INFEASIBLE: FilterStatus

class Header(_message.Message):
    __slots__ = ("schema_version", "source", "epoch", "sequence", "scheduled_ns", "started_ns", "sent_ns", "wall_ns")
    SCHEMA_VERSION_FIELD_NUMBER: _ClassVar[int]
    SOURCE_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    SCHEDULED_NS_FIELD_NUMBER: _ClassVar[int]
    STARTED_NS_FIELD_NUMBER: _ClassVar[int]
    SENT_NS_FIELD_NUMBER: _ClassVar[int]
    WALL_NS_FIELD_NUMBER: _ClassVar[int]
    schema_version: int
    source: str
    epoch: int
    sequence: int
    scheduled_ns: int
    started_ns: int
    sent_ns: int
    wall_ns: int
    def __init__(self, schema_version: _Optional[int] = ..., source: _Optional[str] = ..., epoch: _Optional[int] = ..., sequence: _Optional[int] = ..., scheduled_ns: _Optional[int] = ..., started_ns: _Optional[int] = ..., sent_ns: _Optional[int] = ..., wall_ns: _Optional[int] = ...) -> None: ...

class OperatorCommand(_message.Message):
    __slots__ = ("header", "u_h", "u_h_rate", "enabled", "device")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    U_H_FIELD_NUMBER: _ClassVar[int]
    U_H_RATE_FIELD_NUMBER: _ClassVar[int]
    ENABLED_FIELD_NUMBER: _ClassVar[int]
    DEVICE_FIELD_NUMBER: _ClassVar[int]
    header: Header
    u_h: _containers.RepeatedScalarFieldContainer[float]
    u_h_rate: _containers.RepeatedScalarFieldContainer[float]
    enabled: bool
    device: str
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., u_h: _Optional[_Iterable[float]] = ..., u_h_rate: _Optional[_Iterable[float]] = ..., enabled: _Optional[bool] = ..., device: _Optional[str] = ...) -> None: ...

class PlantInput(_message.Message):
    __slots__ = ("header", "tick", "u", "effective_plant_ns", "hold_ns", "armed_from_ns", "basis_ns", "earlier")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    TICK_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    EFFECTIVE_PLANT_NS_FIELD_NUMBER: _ClassVar[int]
    HOLD_NS_FIELD_NUMBER: _ClassVar[int]
    ARMED_FROM_NS_FIELD_NUMBER: _ClassVar[int]
    BASIS_NS_FIELD_NUMBER: _ClassVar[int]
    EARLIER_FIELD_NUMBER: _ClassVar[int]
    header: Header
    tick: int
    u: _containers.RepeatedScalarFieldContainer[float]
    effective_plant_ns: int
    hold_ns: int
    armed_from_ns: int
    basis_ns: int
    earlier: _containers.RepeatedScalarFieldContainer[float]
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., tick: _Optional[int] = ..., u: _Optional[_Iterable[float]] = ..., effective_plant_ns: _Optional[int] = ..., hold_ns: _Optional[int] = ..., armed_from_ns: _Optional[int] = ..., basis_ns: _Optional[int] = ..., earlier: _Optional[_Iterable[float]] = ...) -> None: ...

class PlantState(_message.Message):
    __slots__ = ("header", "plant_ns", "x", "y", "u", "applied_tick", "phase", "energy_in_j", "energy_stored_j", "input_slack_ns", "inputs_late", "inputs_refused", "integration_error", "received_tick", "disarmed_ns", "since_ns", "input_transit_ns", "input_epoch")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    PLANT_NS_FIELD_NUMBER: _ClassVar[int]
    X_FIELD_NUMBER: _ClassVar[int]
    Y_FIELD_NUMBER: _ClassVar[int]
    U_FIELD_NUMBER: _ClassVar[int]
    APPLIED_TICK_FIELD_NUMBER: _ClassVar[int]
    PHASE_FIELD_NUMBER: _ClassVar[int]
    ENERGY_IN_J_FIELD_NUMBER: _ClassVar[int]
    ENERGY_STORED_J_FIELD_NUMBER: _ClassVar[int]
    INPUT_SLACK_NS_FIELD_NUMBER: _ClassVar[int]
    INPUTS_LATE_FIELD_NUMBER: _ClassVar[int]
    INPUTS_REFUSED_FIELD_NUMBER: _ClassVar[int]
    INTEGRATION_ERROR_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_TICK_FIELD_NUMBER: _ClassVar[int]
    DISARMED_NS_FIELD_NUMBER: _ClassVar[int]
    SINCE_NS_FIELD_NUMBER: _ClassVar[int]
    INPUT_TRANSIT_NS_FIELD_NUMBER: _ClassVar[int]
    INPUT_EPOCH_FIELD_NUMBER: _ClassVar[int]
    header: Header
    plant_ns: int
    x: _containers.RepeatedScalarFieldContainer[float]
    y: _containers.RepeatedScalarFieldContainer[float]
    u: _containers.RepeatedScalarFieldContainer[float]
    applied_tick: int
    phase: PlantPhase
    energy_in_j: float
    energy_stored_j: float
    input_slack_ns: int
    inputs_late: int
    inputs_refused: int
    integration_error: float
    received_tick: int
    disarmed_ns: int
    since_ns: int
    input_transit_ns: int
    input_epoch: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., plant_ns: _Optional[int] = ..., x: _Optional[_Iterable[float]] = ..., y: _Optional[_Iterable[float]] = ..., u: _Optional[_Iterable[float]] = ..., applied_tick: _Optional[int] = ..., phase: _Optional[_Union[PlantPhase, str]] = ..., energy_in_j: _Optional[float] = ..., energy_stored_j: _Optional[float] = ..., input_slack_ns: _Optional[int] = ..., inputs_late: _Optional[int] = ..., inputs_refused: _Optional[int] = ..., integration_error: _Optional[float] = ..., received_tick: _Optional[int] = ..., disarmed_ns: _Optional[int] = ..., since_ns: _Optional[int] = ..., input_transit_ns: _Optional[int] = ..., input_epoch: _Optional[int] = ...) -> None: ...

class BarrierChain(_message.Message):
    __slots__ = ("name", "psi", "eps")
    NAME_FIELD_NUMBER: _ClassVar[int]
    PSI_FIELD_NUMBER: _ClassVar[int]
    EPS_FIELD_NUMBER: _ClassVar[int]
    name: str
    psi: _containers.RepeatedScalarFieldContainer[float]
    eps: float
    def __init__(self, name: _Optional[str] = ..., psi: _Optional[_Iterable[float]] = ..., eps: _Optional[float] = ...) -> None: ...

class Row(_message.Message):
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

class Override(_message.Message):
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
    __slots__ = ("topic", "sequence", "received_ns", "epoch")
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    RECEIVED_NS_FIELD_NUMBER: _ClassVar[int]
    EPOCH_FIELD_NUMBER: _ClassVar[int]
    topic: str
    sequence: int
    received_ns: int
    epoch: int
    def __init__(self, topic: _Optional[str] = ..., sequence: _Optional[int] = ..., received_ns: _Optional[int] = ..., epoch: _Optional[int] = ...) -> None: ...

class FilterTick(_message.Message):
    __slots__ = ("header", "tick", "status", "mode", "law", "effective_plant_ns", "x_hat", "u_h", "u_h_rate", "u_nominal", "phi", "v", "u", "barriers", "power_margin", "tank_j", "slack", "rows", "certificate", "consumed", "state_age_ns", "command_age_ns", "override", "horizon_ns")
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
    barriers: _containers.RepeatedCompositeFieldContainer[BarrierChain]
    power_margin: float
    tank_j: float
    slack: float
    rows: _containers.RepeatedCompositeFieldContainer[Row]
    certificate: Certificate
    consumed: _containers.RepeatedCompositeFieldContainer[Consumed]
    state_age_ns: int
    command_age_ns: int
    override: Override
    horizon_ns: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., tick: _Optional[int] = ..., status: _Optional[_Union[FilterStatus, str]] = ..., mode: _Optional[str] = ..., law: _Optional[str] = ..., effective_plant_ns: _Optional[int] = ..., x_hat: _Optional[_Iterable[float]] = ..., u_h: _Optional[_Iterable[float]] = ..., u_h_rate: _Optional[_Iterable[float]] = ..., u_nominal: _Optional[_Iterable[float]] = ..., phi: _Optional[_Iterable[float]] = ..., v: _Optional[_Iterable[float]] = ..., u: _Optional[_Iterable[float]] = ..., barriers: _Optional[_Iterable[_Union[BarrierChain, _Mapping]]] = ..., power_margin: _Optional[float] = ..., tank_j: _Optional[float] = ..., slack: _Optional[float] = ..., rows: _Optional[_Iterable[_Union[Row, _Mapping]]] = ..., certificate: _Optional[_Union[Certificate, _Mapping]] = ..., consumed: _Optional[_Iterable[_Union[Consumed, _Mapping]]] = ..., state_age_ns: _Optional[int] = ..., command_age_ns: _Optional[int] = ..., override: _Optional[_Union[Override, _Mapping]] = ..., horizon_ns: _Optional[int] = ...) -> None: ...

class LinkConfig(_message.Message):
    __slots__ = ("header", "link", "delay_s", "jitter_s", "loss", "seed")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LINK_FIELD_NUMBER: _ClassVar[int]
    DELAY_S_FIELD_NUMBER: _ClassVar[int]
    JITTER_S_FIELD_NUMBER: _ClassVar[int]
    LOSS_FIELD_NUMBER: _ClassVar[int]
    SEED_FIELD_NUMBER: _ClassVar[int]
    header: Header
    link: str
    delay_s: float
    jitter_s: float
    loss: float
    seed: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., link: _Optional[str] = ..., delay_s: _Optional[float] = ..., jitter_s: _Optional[float] = ..., loss: _Optional[float] = ..., seed: _Optional[int] = ...) -> None: ...

class LinkEvent(_message.Message):
    __slots__ = ("header", "link", "effect", "topic", "sequence")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    LINK_FIELD_NUMBER: _ClassVar[int]
    EFFECT_FIELD_NUMBER: _ClassVar[int]
    TOPIC_FIELD_NUMBER: _ClassVar[int]
    SEQUENCE_FIELD_NUMBER: _ClassVar[int]
    header: Header
    link: str
    effect: str
    topic: str
    sequence: int
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., link: _Optional[str] = ..., effect: _Optional[str] = ..., topic: _Optional[str] = ..., sequence: _Optional[int] = ...) -> None: ...

class Health(_message.Message):
    __slots__ = ("header", "rate_hz", "steps", "overruns", "ticks_missed", "late_us_max", "topics")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    RATE_HZ_FIELD_NUMBER: _ClassVar[int]
    STEPS_FIELD_NUMBER: _ClassVar[int]
    OVERRUNS_FIELD_NUMBER: _ClassVar[int]
    TICKS_MISSED_FIELD_NUMBER: _ClassVar[int]
    LATE_US_MAX_FIELD_NUMBER: _ClassVar[int]
    TOPICS_FIELD_NUMBER: _ClassVar[int]
    header: Header
    rate_hz: float
    steps: int
    overruns: int
    ticks_missed: int
    late_us_max: float
    topics: _containers.RepeatedCompositeFieldContainer[TopicHealth]
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., rate_hz: _Optional[float] = ..., steps: _Optional[int] = ..., overruns: _Optional[int] = ..., ticks_missed: _Optional[int] = ..., late_us_max: _Optional[float] = ..., topics: _Optional[_Iterable[_Union[TopicHealth, _Mapping]]] = ...) -> None: ...

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

class Event(_message.Message):
    __slots__ = ("header", "severity", "text")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SEVERITY_FIELD_NUMBER: _ClassVar[int]
    TEXT_FIELD_NUMBER: _ClassVar[int]
    header: Header
    severity: str
    text: str
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., severity: _Optional[str] = ..., text: _Optional[str] = ...) -> None: ...

class ScenarioInfo(_message.Message):
    __slots__ = ("header", "scenario_json", "driver", "versions_json")
    HEADER_FIELD_NUMBER: _ClassVar[int]
    SCENARIO_JSON_FIELD_NUMBER: _ClassVar[int]
    DRIVER_FIELD_NUMBER: _ClassVar[int]
    VERSIONS_JSON_FIELD_NUMBER: _ClassVar[int]
    header: Header
    scenario_json: str
    driver: str
    versions_json: str
    def __init__(self, header: _Optional[_Union[Header, _Mapping]] = ..., scenario_json: _Optional[str] = ..., driver: _Optional[str] = ..., versions_json: _Optional[str] = ...) -> None: ...
