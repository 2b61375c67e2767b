"""Classifies the messages of a source whose sessions may send side by side: one guard for each."""

from passafe_protocol.messages import Header
from passafe_protocol.sequence import SESSIONS, Arrival, SequenceGuard, Session
from passafe_protocol.topics import Topic


class SessionGuards:
    """Classifies the messages of one source on a topic that admits any session (``Topic.any_session``).

    No session ends another, so that neither an older nor a newer one locks it out: the node decides which counts. The
    ``SESSIONS`` received from last are remembered; an older one begins anew.

    Attributes:
        received: Distinct messages of all sessions.
        refused: DUPLICATE messages.
    """

    def __init__(self) -> None:
        self._guards: dict[int, SequenceGuard] = {}  # the one received from last comes last
        self._received = self._refused = self._gaps = 0  # of sessions that are forgotten

    @property
    def received(self) -> int:
        """Distinct messages of all sessions."""
        return self._received + sum(guard.received for guard in self._guards.values())

    @property
    def refused(self) -> int:
        """Messages that were duplicates."""
        return self._refused + sum(guard.refused for guard in self._guards.values())

    @property
    def gaps(self) -> int:
        """Sequence numbers never received, of each session between its first and its newest."""
        return self._gaps + sum(guard.gaps for guard in self._guards.values())

    @property
    def sessions(self) -> tuple[Session, ...]:
        """The remembered sessions; the one received from last comes last."""
        return tuple(session for guard in self._guards.values() for session in guard.sessions)

    def classify(self, header: Header) -> Arrival:
        """Classify the message with this header and remember it."""
        guards = self._guards
        guard = guards.pop(header.epoch, None)
        if guard is None:
            guard = SequenceGuard()
            if len(guards) == SESSIONS:
                self._forget(guards.pop(next(iter(guards))))
        guards[header.epoch] = guard
        return guard.classify(header)

    def _forget(self, guard: SequenceGuard) -> None:
        self._received += guard.received
        self._refused += guard.refused
        self._gaps += guard.gaps


def guard_of(topic: Topic) -> SequenceGuard | SessionGuards:
    """Return the guard for one source of a topic."""
    return SessionGuards() if topic.any_session else SequenceGuard()
