"""Press of the emergency stop, or clear of one, repeated until a plant state acknowledges it: pure, without a clock."""

from typing import Final

from passafe_protocol.messages import EmergencyStop, PlantState, StopClear

REPEAT_NS: Final = 10_000_000
"""Period of the repeats: a lost message costs no more."""

_MIX: Final = 0x9E37_79B9_7F4A_7C15
"""Odd, so that n·_MIX mod 2⁶⁴ has 2⁶⁴ values."""

_COUNT: Final = 2**64


def press_id(epoch: int, number: int) -> int:
    """Return the id of a session's press; other presses and other sessions have other ids.

    Args:
        epoch: Session of the sender.
        number: Counts its presses.
    """
    return (epoch + number * _MIX) % _COUNT or _MIX


class StopRequest:
    """A press or a clear that is repeated until it is done.

    A press is done when a plant state names it, a clear when one no longer names its stop.

    Attributes:
        body: The message.
        is_done: Whether a plant state has acknowledged it.
    """

    def __init__(self, body: EmergencyStop | StopClear) -> None:
        """Start with nothing sent.

        Args:
            body: The message.
        """
        self.body = body
        self.is_done = False
        self._due_ns: int | None = None

    def due(self, now_ns: int) -> EmergencyStop | StopClear | None:
        """Return the message if it is to be sent now.

        Args:
            now_ns: Monotonic time, ns.
        """
        if self.is_done or (self._due_ns is not None and now_ns < self._due_ns):
            return None
        self._due_ns = now_ns + REPEAT_NS
        return self.body

    def observe(self, state: PlantState) -> None:
        """Learn from a plant state that was received after the request began."""
        if isinstance(self.body, EmergencyStop):
            self.is_done = self.is_done or state.stop == self.body.id
        else:
            self.is_done = self.is_done or state.stop != self.body.stop
