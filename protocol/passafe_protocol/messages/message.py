"""Bodies that a message may have, and a message as a node receives it."""

from typing import TypeAlias

from passafe_protocol.messages.driving import EmergencyStop, OperatorCommand, OperatorLease, Steer, StopClear
from passafe_protocol.messages.header import Header
from passafe_protocol.messages.links import LinkConfig, LinkEvent, LinkState
from passafe_protocol.messages.plant import PlantInput, PlantState
from passafe_protocol.messages.process import Event, Health, Receipt, ScenarioInfo
from passafe_protocol.messages.record import Record
from passafe_protocol.messages.tick import FilterTick

Message: TypeAlias = (
    OperatorCommand
    | Steer
    | EmergencyStop
    | StopClear
    | OperatorLease
    | PlantInput
    | PlantState
    | FilterTick
    | LinkConfig
    | LinkEvent
    | LinkState
    | Health
    | Receipt
    | Event
    | ScenarioInfo
)


class Received(Record, frozen=True):
    """Message received by a node, with the time at which it left its link.

    ``term`` orders the sessions of its sender: it counts the changes of session that the process had seen when the
    message entered the link. Epochs do not order them.
    """

    header: Header
    body: Message
    received_ns: int
    term: int = 0
