"""Input sequence at the plant: inputs that take effect only if all previous ones of the sequence did."""

from collections.abc import Callable
from typing import Final

from msgspec import Struct
from passafe_protocol.messages import UNSEQUENCED, PlantInput, Vector

MOST_AHEAD: Final = 16_384
"""Periods that an input may lie ahead of the plant, 16 s at 1 kHz: bounds the memory that a faulty sender can use."""

NOTHING_NEW: Final = -1
"""The message contains no new input that can still take effect."""

REFUSED: Final = -2
"""The message is not of the current sequence."""

_Identity = tuple[int, int, int]
"""Term of the filter's session (``Received.term``), known break and first plant time of a sequence."""


class SequencedInput(Struct, frozen=True, gc=False):
    """One input of a sequence."""

    u: Vector
    tick: int
    hold_ns: int


class SequencedInputs:
    """Pending inputs of one sequence, by the plant time at which they take effect.

    A sequence runs from its first input until one is missing. That breaks it: all pending inputs are void, and only a
    sequence predicted from this break (``known_break_ns``) can begin. Hence, whatever the network does, no input takes
    effect in a state other than the one for which it was decided.

    Attributes:
        is_running: Whether the input in force belongs to a sequence.
        sequence_break_ns: Plant time of the last break, ns; −1 before the first.
    """

    def __init__(self, period_ns: int, is_applicable: Callable[[Vector], bool]) -> None:
        """Start without a sequence.

        Args:
            period_ns: Period of the plant, ns.
            is_applicable: Checks whether the plant can apply an input.
        """
        self._period_ns = period_ns
        self._is_applicable = is_applicable
        self._pending: dict[int, SequencedInput] = {}
        self._identity: _Identity | None = None
        self._broken: _Identity | None = None
        self._reported_break: _Identity | None = None
        self._popped_ns: int | None = None
        self._newest_ns = 0
        self.is_running = False
        self.sequence_break_ns = UNSEQUENCED

    @property
    def first_ns(self) -> int:
        """Plant time of the first input of the pending sequence, ns; −1 without one."""
        return UNSEQUENCED if self._identity is None else self._identity[2]

    def receive(self, term: int, body: PlantInput) -> int:
        """Add the inputs of a message.

        Args:
            term: Term of its sender's session.
            body: The message.

        Returns:
            Age of the oldest new input, in periods before the newest input of the message; ``NOTHING_NEW`` if no new
            input can still take effect; ``REFUSED`` if the message is of another sequence, starts from a break that
            did not happen, or is too far ahead.
        """
        identity = (term, body.known_break_ns, body.input_sequence_start_ns)
        due_ns, popped_ns = body.effective_plant_ns, self._popped_ns
        if not self._is_near(body) or (identity != self._identity and not self._begin(identity, body)):
            return REFUSED
        oldest = NOTHING_NEW
        if popped_ns is not None and due_ns <= popped_ns:
            return oldest
        if due_ns not in self._pending:
            self._pending[due_ns] = SequencedInput(body.u, body.tick, body.hold_ns)
            oldest = 0
        self._newest_ns = max(due_ns, self._newest_ns)
        if self._has_gaps():
            oldest = max(oldest, self._add_repeated(body))
        return oldest

    def pop_due(self, plant_ns: int) -> SequencedInput | None:
        """Return the input that takes effect now; ``None`` breaks a running sequence.

        Args:
            plant_ns: Plant time, ns, later than in the previous call.
        """
        self._popped_ns = plant_ns
        due = self._pending.pop(plant_ns, None)
        if self.is_running:
            if due is None:
                self._broken = self._identity
                self._break_sequence(plant_ns)
            return due
        if self._identity is None or self._identity[2] > plant_ns:
            return None
        if due is None or self._identity[2] < plant_ns:  # its first input did not arrive in time
            self._discard()
            return None
        self.is_running = True
        return due

    def periods_late(self, term: int, body: PlantInput) -> int:
        """Return the age of the missing input in a refused message, in periods before the newest input of the message.

        Zero unless the message is the first one that contains the input whose absence broke its sequence: a loss that a
        longer play-out time would have bridged.
        """
        identity = (term, body.known_break_ns, body.input_sequence_start_ns)
        if identity == self._broken:
            missing_ns = self.sequence_break_ns
        elif (
            not self.is_running
            and body.known_break_ns == self.sequence_break_ns
            and self._is_past(body.input_sequence_start_ns)
        ):
            missing_ns = body.input_sequence_start_ns
        else:
            return 0
        periods = (body.effective_plant_ns - missing_ns) // self._period_ns
        if identity == self._reported_break or not 0 <= periods <= len(body.previous_u) // len(body.u):
            return 0
        self._reported_break = identity
        return periods

    def void(self, plant_ns: int) -> None:
        """Discard all inputs for an emergency stop or its clear; a sequence that has begun breaks.

        Args:
            plant_ns: Plant time, ns.
        """
        if self._popped_ns is None:
            self._discard()
        else:
            self._popped_ns = plant_ns
            self._broken = None
            self._break_sequence(plant_ns)

    def _break_sequence(self, plant_ns: int) -> None:
        """Discard all inputs that were predicted from a state before this break."""
        self.is_running = False
        self.sequence_break_ns = plant_ns
        self._discard()

    def _is_past(self, plant_ns: int) -> bool:
        return self._popped_ns is not None and plant_ns <= self._popped_ns

    def _is_near(self, body: PlantInput) -> bool:
        """Check that the times of a message lie on the grid of its sequence and not too far ahead."""
        due_ns, first_ns = body.effective_plant_ns, body.input_sequence_start_ns
        now_ns = first_ns if self._popped_ns is None else self._popped_ns
        ahead_ns = due_ns - now_ns
        is_on_grid = (due_ns - first_ns) % self._period_ns == 0 == ahead_ns % self._period_ns
        return is_on_grid and first_ns <= due_ns and ahead_ns <= MOST_AHEAD * self._period_ns

    def _begin(self, identity: _Identity, body: PlantInput) -> bool:
        """Begin another sequence if it can still start and is newer than the pending one."""
        _, known_break_ns, first_ns = identity
        if (
            self.is_running
            or known_break_ns != self.sequence_break_ns
            or (self._identity is not None and identity < self._identity)
        ):
            return False
        if self._popped_ns is None:
            # Plant time begins with the first input of this sequence, so the message must contain it.
            if body.effective_plant_ns - first_ns > len(body.previous_u) // len(body.u) * self._period_ns:
                return False
        elif self._is_past(first_ns):
            return False
        self._pending.clear()
        self._identity = identity
        self._newest_ns = first_ns - self._period_ns
        return True

    def _has_gaps(self) -> bool:
        """Check whether an input is missing between the one that took effect last and the newest."""
        before_ns = self.first_ns - self._period_ns
        if self._popped_ns is not None and self._popped_ns > before_ns:
            before_ns = self._popped_ns
        return len(self._pending) * self._period_ns < self._newest_ns - before_ns

    def _add_repeated(self, body: PlantInput) -> int:
        """Add repeated inputs that are missing; return the age of the oldest one in periods."""
        m, oldest, waiting = len(body.u), NOTHING_NEW, self._pending
        least_ns, due_ns = self.first_ns, body.effective_plant_ns
        if self._popped_ns is not None:
            least_ns = max(least_ns, self._popped_ns + 1)
        for i in range(1, len(body.previous_u) // m + 1):
            due_ns -= self._period_ns
            if due_ns < least_ns:
                break
            if due_ns not in waiting:
                u = body.previous_u[(i - 1) * m : i * m]
                if self._is_applicable(u):
                    waiting[due_ns] = SequencedInput(u, body.tick - i, body.hold_ns)
                    oldest = i
        return oldest

    def _discard(self) -> None:
        self._pending.clear()
        self._identity = None
