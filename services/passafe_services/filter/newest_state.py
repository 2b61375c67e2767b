"""Newest plant state that the filter received."""

from typing import Final

from passafe_protocol.messages import PlantPhase, PlantState, Received

from passafe.system import System
from passafe_services.filter.send_time import SendTime

LONGEST_PERIOD_NS: Final = 100_000_000
"""Period of the slowest plant, ns: the most by which its time advances from one state to the next."""

_WAITING: Final = PlantPhase.WAITING


class NewestState:
    """Keeps the newest state of the plant's current session; older and duplicate ones are ignored.

    Attributes:
        state: The newest state, or ``None`` before the first.
        epoch: Session of the plant; 0 before the first state.
    """

    def __init__(self, system: System, send_time: SendTime) -> None:
        """Start before the first state.

        Args:
            system: The plant, whose states, inputs and outputs are counted.
            send_time: Estimates when states were sent.
        """
        self._sizes = (system.n, system.m, int(system.y.numel()))
        self._send_time = send_time
        self.restart(0)

    def restart(self, epoch: int, term: int = 0) -> None:
        """Discard the newest state: the plant was restarted.

        Args:
            epoch: The new session.
            term: Its term (``Received.term``).
        """
        self.state: PlantState | None = None
        self.epoch = epoch
        self._term = term
        self._send_time.restart()
        self._sent_ns = self._received_ns = 0
        self._sequence = -1

    def receive(self, received: Received, state: PlantState) -> bool:
        """Keep a state if it fits the filter's model and is the newest; return whether it is.

        A session of a later term replaces the current one: ``epoch`` changes.

        Args:
            received: The message.
            state: Its body.
        """
        if (len(state.x), len(state.u), len(state.y)) != self._sizes:
            return False
        header, newest = received.header, self.state
        if received.term > self._term or (header.epoch != self.epoch and received.term == self._term):
            self.restart(header.epoch, received.term)
        elif (
            received.term < self._term
            or header.sequence <= self._sequence  # a duplicate does not refresh the age
            or (newest is not None and not self._follows(header.sequence, state, newest))
        ):
            return False
        self.state, self._sequence = state, header.sequence
        self._sent_ns, self._received_ns = self._send_time.of(received), received.received_ns
        return True

    def _follows(self, sequence: int, state: PlantState, newest: PlantState) -> bool:
        """Check that plant time can have advanced so: one forged state must not make all later ones seem old."""
        advance_ns = state.plant_ns - newest.plant_ns
        longest_ns = (sequence - self._sequence) * LONGEST_PERIOD_NS
        return advance_ns >= 0 and (advance_ns <= longest_ns or newest.phase is _WAITING)

    def age_ns(self, now_ns: int) -> int:
        """Return the age of the newest state since it was sent, ns.

        Args:
            now_ns: Monotonic time, ns.
        """
        return max(now_ns - self._sent_ns, 0)

    def silence_ns(self, now_ns: int) -> int:
        """Return the time since the newest state arrived, ns: the prediction covers its time on the way, but not this.

        Args:
            now_ns: Monotonic time, ns.
        """
        return max(now_ns - self._received_ns, 0)
