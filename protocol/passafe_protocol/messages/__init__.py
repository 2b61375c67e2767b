"""Messages as Python values: one immutable record for each message of ``passafe.proto``.

Nodes exchange these records, never protobuf, so that a closed loop in one process needs no encoding. Field names, units
and meanings are those of ``passafe.proto``; the header is kept beside the body.
"""

from passafe_protocol.messages.driving import EmergencyStop, OperatorCommand, OperatorLease, Steer, StopClear, WhoDrives
from passafe_protocol.messages.header import SCHEMA_VERSION, UNKNOWN_CLOCK, VIRTUAL_CLOCK, Header
from passafe_protocol.messages.links import LinkConfig, LinkEvent, LinkOutage, LinkParameters, LinkSource, LinkState
from passafe_protocol.messages.message import Message, Received
from passafe_protocol.messages.plant import UNSEQUENCED, GuardAction, PlantInput, PlantPhase, PlantState
from passafe_protocol.messages.process import (
    Event,
    EventKind,
    Health,
    Receipt,
    RecordedSession,
    ScenarioInfo,
    TopicHealth,
)
from passafe_protocol.messages.record import Record, Vector
from passafe_protocol.messages.tick import (
    BY_SEVERITY,
    BarrierReport,
    Certificate,
    CommandState,
    Consumed,
    FilterStatus,
    FilterTick,
    OverrideReport,
    RowReport,
)

__all__ = [
    "BY_SEVERITY",
    "SCHEMA_VERSION",
    "UNKNOWN_CLOCK",
    "UNSEQUENCED",
    "VIRTUAL_CLOCK",
    "BarrierReport",
    "Certificate",
    "CommandState",
    "Consumed",
    "EmergencyStop",
    "Event",
    "EventKind",
    "FilterStatus",
    "FilterTick",
    "GuardAction",
    "Header",
    "Health",
    "LinkConfig",
    "LinkEvent",
    "LinkOutage",
    "LinkParameters",
    "LinkSource",
    "LinkState",
    "Message",
    "OperatorCommand",
    "OperatorLease",
    "OverrideReport",
    "PlantInput",
    "PlantPhase",
    "PlantState",
    "Receipt",
    "Received",
    "Record",
    "RecordedSession",
    "RowReport",
    "ScenarioInfo",
    "Steer",
    "StopClear",
    "TopicHealth",
    "Vector",
    "WhoDrives",
]
