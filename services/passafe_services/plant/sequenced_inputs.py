"""Inputs that are good only together: an arming, of which every one was made for what the ones before it lead to."""

from collections.abc import Callable
from typing import Final

from msgspec import Struct
from passafe_protocol.messages import UNSEQUENCED, Header, PlantInput, Vector

MOST_AHEAD: Final = 16_384
"""Periods that an input may lie ahead of the plant, 16 s at 1 kHz: a sender of nonsense fills no memory."""

REPEATED: Final = -1
"""The message brought nothing that can still take effect."""

REFUSED: Final = -2
"""The message is not of the arming."""

_Identity = tuple[int, int, int]
"""Session of the filter, basis and first plant time of an arming."""


class SequencedInput(Struct, frozen=True, gc=False):
    """One input of an arming."""

    u: Vector
    tick: int
    hold_ns: int


class SequencedInputs:
    """The inputs of one arming that have not taken effect yet, by the plant time at which they will.

    The plant is *armed* from the first input of an arming on, until one is missing. Then it is disarmed, all that it
    holds is void, and only an arming that rests on that very moment (``known_break_ns``) can arm it again. So whatever
    the network does, no input takes effect in a state other than the one it was made for.

    Attributes:
        armed: Whether the input in force is one of an arming.
        sequence_break_ns: Plant time at which an input was missing last; −1 before the first time.
        first_ns: Plant time at which the arming that is held begins; −1 if none is held.
    """

    def __init__(self, period_ns: int, is_applicable: Callable[[Vector], bool]) -> None:
        """Start disarmed and empty.

        Args:
            period_ns: Period of the plant, ns.
            is_applicable: Tells whether the plant can apply an input.
        """
        self._period_ns = period_ns
        self._is_applicable = is_applicable
        self._waiting: dict[int, SequencedInput] = {}
        self._identity: _Identity | None = None
        self._broken: _Identity | None = None
        self._told: _Identity | None = None
        self._taken_ns: int | None = None
        self._newest_ns = 0
        self.armed = False
        self.sequence_break_ns = UNSEQUENCED

    @property
    def first_ns(self) -> int:
        """Plant time of the first input of what is held."""
        return UNSEQUENCED if self._identity is None else self._identity[2]

    def put(self, header: Header, body: PlantInput) -> int:
        """Take the inputs of a message in.

        Returns:
            How many periods before the newest input of the message the oldest lies that was not known before;
            ``REPEATED`` if the message brought nothing that can still take effect, ``REFUSED`` if it is not of this
            arming: foreign, made for something that did not happen, or too far ahead.
        """
        identity = (header.epoch, body.known_break_ns, body.input_sequence_start_ns)
        due_ns, taken_ns = body.effective_plant_ns, self._taken_ns
        if not self._is_near(body) or (identity != self._identity and not self._begin(identity, body)):
            return REFUSED
        oldest = REPEATED
        if taken_ns is not None and due_ns <= taken_ns:
            return oldest
        if due_ns not in self._waiting:
            self._waiting[due_ns] = SequencedInput(body.u, body.tick, body.hold_ns)
            oldest = 0
        self._newest_ns = max(due_ns, self._newest_ns)
        if self._has_gaps():
            oldest = max(oldest, self._fill(body))
        return oldest

    def take(self, plant_ns: int) -> SequencedInput | None:
        """Return the input that takes effect now, or ``None``: then the plant is disarmed, if it was not before.

        Args:
            plant_ns: Plant time, later than in the call before.
        """
        self._taken_ns = plant_ns
        due = self._waiting.pop(plant_ns, None)
        if self.armed:
            if due is None:
                self._broken = self._identity
                self._break_off(plant_ns)
            return due
        if self._identity is None or self._identity[2] > plant_ns:
            return None
        if due is None or self._identity[2] < plant_ns:  # its first input did not come in time
            self._forget()
            return None
        self.armed = True
        return due

    def missed(self, header: Header, body: PlantInput) -> int:
        """Return how late the input came that was missing last, in periods before the newest of the message with it.

        Of a message that ``put`` refused. Zero if it is not the first one that brings what its arming lacked: a loss
        that broke the arming, and that a longer play-out time would have bridged.
        """
        identity = (header.epoch, body.known_break_ns, body.input_sequence_start_ns)
        if identity == self._broken:
            missing_ns = self.sequence_break_ns
        elif (
            not self.armed
            and body.known_break_ns == self.sequence_break_ns
            and self._is_over(body.input_sequence_start_ns)
        ):
            missing_ns = body.input_sequence_start_ns
        else:
            return 0
        periods = (body.effective_plant_ns - missing_ns) // self._period_ns
        if identity == self._told or not 0 <= periods <= len(body.previous_u) // len(body.u):
            return 0
        self._told = identity
        return periods

    def _break_off(self, plant_ns: int) -> None:
        """Let nothing take effect that was made for an input before this break."""
        self.armed = False
        self.sequence_break_ns = plant_ns
        self._forget()

    def _is_over(self, plant_ns: int) -> bool:
        return self._taken_ns is not None and plant_ns <= self._taken_ns

    def _is_near(self, body: PlantInput) -> bool:
        """Tell whether a message's times lie on the grid of its arming, and not too far ahead."""
        due_ns, first_ns = body.effective_plant_ns, body.input_sequence_start_ns
        now_ns = first_ns if self._taken_ns is None else self._taken_ns
        ahead_ns = due_ns - now_ns
        is_on_grid = (due_ns - first_ns) % self._period_ns == 0 == ahead_ns % self._period_ns
        return is_on_grid and first_ns <= due_ns and ahead_ns <= MOST_AHEAD * self._period_ns

    def _begin(self, identity: _Identity, body: PlantInput) -> bool:
        """Hold another arming from now on, if it can still begin and is newer than the one that is held."""
        _, known_break_ns, first_ns = identity
        if (
            self.armed
            or known_break_ns != self.sequence_break_ns
            or (self._identity is not None and identity < self._identity)
        ):
            return False
        if self._taken_ns is None:
            # Plant time has not begun, and will with this arming's first input: the message has to hold that one.
            if body.effective_plant_ns - first_ns > len(body.previous_u) // len(body.u) * self._period_ns:
                return False
        elif self._is_over(first_ns):
            return False
        self._waiting.clear()
        self._identity = identity
        self._newest_ns = first_ns - self._period_ns
        return True

    def _has_gaps(self) -> bool:
        """Tell whether an input is missing between the one that took effect last and the newest."""
        before_ns = self.first_ns - self._period_ns
        if self._taken_ns is not None and self._taken_ns > before_ns:
            before_ns = self._taken_ns
        return len(self._waiting) * self._period_ns < self._newest_ns - before_ns

    def _fill(self, body: PlantInput) -> int:
        """Take in what a message repeats of inputs that did not come; return how far back the oldest lies."""
        m, oldest, waiting = len(body.u), REPEATED, self._waiting
        least_ns, due_ns = self.first_ns, body.effective_plant_ns
        if self._taken_ns is not None:
            least_ns = max(least_ns, self._taken_ns + 1)
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

    def _forget(self) -> None:
        self._waiting.clear()
        self._identity = None
