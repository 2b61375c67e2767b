"""Messages of who drives: commands, the page that steers, the lease, and the emergency stop."""

from enum import StrEnum

from passafe_protocol.messages.record import Record, Vector


class OperatorCommand(Record, frozen=True):
    """Command of the operator: ``u_h`` and, if the device provides it, its rate.

    The echo of a plant state bounds the command's age at a filter whose clock the operator does not read.
    """

    u_h: Vector
    u_h_rate: Vector
    enabled: bool
    device: str
    echoed_epoch: int = 0
    echoed_ns: int = 0
    echoed_for_ns: int = 0
    take_over: int = 0


class WhoDrives(StrEnum):
    """Driver that the page names."""

    PAGE = "page"
    """A page, by its commands."""

    NOBODY = "nobody"
    """Nobody: the page that drove released, or fell silent."""

    SCRIPT = "script"
    """The operator's own source: the scenario's script."""


class Steer(Record, frozen=True):
    """Driver that the page names, and its newest command.

    The echo of an operator's command bounds the age of this one at an operator whose clock the dashboard does not read.
    """

    turn: int
    driver: str
    page: int = 0
    shares: Vector = ()
    engaged: bool = False
    age_ns: int = 0
    take_over: bool = False
    echoed_epoch: int = 0
    echoed_ns: int = 0
    echoed_for_ns: int = 0


class EmergencyStop(Record, frozen=True):
    """Press of the emergency stop: the plant latches it until it is cleared by its id."""

    id: int
    reason: str


class StopClear(Record, frozen=True):
    """Clears the emergency stop of this id."""

    stop: int
    reason: str


class OperatorLease(Record, frozen=True):
    """Lease of the operator whose commands count; ``holder`` is the epoch of its session, 0 for nobody."""

    number: int
    holder: int
    device: str
    command_age_ns: int
    refused: int = 0
