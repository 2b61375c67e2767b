"""Messages to and from the plant: its input, and the state that it reports."""

from enum import IntEnum, StrEnum
from typing import Final

from passafe_protocol.messages.record import Record, Vector

UNSEQUENCED: Final = -1
"""Plant time of an unsequenced input's sequence start, and of the last break of a plant that had none."""


class PlantPhase(IntEnum):
    """Origin of the plant's input: see ``passafe.proto``."""

    WAITING = 1
    RUNNING = 2
    HOLDING = 3
    FAIL_SAFE = 4


class PlantInput(Record, frozen=True):
    """Certified input of the filter, in force from ``effective_plant_ns`` on.

    An *input sequence* has one input for every period from ``input_sequence_start_ns`` on, each decided for the state
    to which the previous ones lead. ``previous_u`` repeats the newest of those, so that a lost message does not break
    the sequence.
    """

    tick: int
    u: Vector
    effective_plant_ns: int
    hold_ns: int
    input_sequence_start_ns: int = UNSEQUENCED
    known_break_ns: int = UNSEQUENCED
    previous_u: Vector = ()
    stops_cleared: int = 0


class GuardAction(StrEnum):
    """Answer of the plant's guard to the input that it was asked to pass."""

    NONE = ""
    """There is no guard, or nothing to guard."""

    PASSED = "passed"
    """The input is in force to the last bit."""

    CHANGED = "changed"
    """The nearest input that keeps every row is in force."""

    FAIL_SAFE = "fail-safe"
    """No input is certified to keep every row: the core's fallback is in force."""


class PlantState(Record, frozen=True):
    """State of the robot at ``plant_ns``; ``u`` is in force from then on."""

    plant_ns: int
    x: Vector
    y: Vector
    u: Vector
    applied_tick: int
    phase: PlantPhase
    energy_in_j: float
    energy_stored_j: float
    input_lead_ns: int
    inputs_late: int
    inputs_refused: int
    integration_error: float
    received_tick: int
    sequence_break_ns: int = UNSEQUENCED
    input_since_ns: int = 0
    input_transit_ns: int = 0
    input_epoch: int = 0
    stop: int = 0
    stop_source: str = ""
    stops_cleared: int = 0
    guard: str = ""
    u_asked: Vector = ()
    guard_cause: str = ""
    guarded: int = 0
    true_x: Vector = ()

    @property
    def actual_x(self) -> Vector:
        """State of the robot: the true one where the plant knows it, else the one that was read."""
        return self.true_x or self.x
