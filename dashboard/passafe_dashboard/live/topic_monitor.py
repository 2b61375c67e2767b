"""Count the messages of each topic as they arrive here: rate, age, gaps, refusals.

Age is judged by arrival at this process, never by the sender's clock.
"""

from typing import Final, NamedTuple

from passafe_protocol.messages import Header
from passafe_protocol.sequence_window import Arrival
from passafe_protocol.session_guards import guard_of
from passafe_protocol.topics import Topic

from passafe_dashboard.decimation import NS_PER_S

POLL_S: Final = 0.1
"""The bus is read once a frame, so an age may be too large by about two frames."""

_ACCEPTED: Final = frozenset({Arrival.FRESH, Arrival.REORDERED})


class TopicStatistics(NamedTuple):
    """Statistics of one topic of one publisher.

    Attributes:
        topic: Name of the topic.
        source: Process that publishes it.
        received: Messages accepted.
        gaps: Sequence numbers that never came.
        refused: Messages refused: repeated, or not of the current session.
        rate_hz: Messages a second, over about the last second.
        age_s: Time since the last one.
        late: Whether that is beyond the topic's deadline.
    """

    topic: str
    source: str
    received: int
    gaps: int
    refused: int
    rate_hz: float
    age_s: float
    late: bool


class TopicMonitor:
    """Monitor of one topic of one publisher.

    Args:
        topic: Row of the topic table.
        source: Process that publishes it.
    """

    def __init__(self, topic: Topic, source: str) -> None:
        self._topic = topic
        self._source = source
        self._guard = guard_of(topic)
        self._last_ns = 0
        self._window_start_ns: int | None = None
        self._window_count = 0
        self._rate_hz = 0.0

    def receive(self, header: Header, received_ns: int) -> bool:
        """Count an arrival; return whether the message is valid: of the current session and not received before."""
        if self._guard.classify(header, received_ns) not in _ACCEPTED:
            return False
        self._last_ns = received_ns
        if self._window_start_ns is None:
            self._window_start_ns = received_ns
            return True
        self._window_count += 1
        elapsed_ns = received_ns - self._window_start_ns
        if elapsed_ns >= NS_PER_S:
            self._rate_hz = self._window_count * NS_PER_S / elapsed_ns
            self._window_start_ns, self._window_count = received_ns, 0
        return True

    @property
    def received(self) -> int:
        """Messages accepted."""
        return self._guard.received

    @property
    def gaps(self) -> int:
        """Sequence numbers that never came."""
        return self._guard.gaps

    @property
    def refused(self) -> int:
        """Messages refused."""
        return self._guard.refused

    def age_s(self, now_ns: int) -> float:
        """Return the seconds since the last message accepted."""
        return max(0, now_ns - self._last_ns) / NS_PER_S

    def statistics(self, now_ns: int) -> TopicStatistics:
        """Return the statistics at ``now_ns``; the rate of a topic that fell silent decays as 1 / age."""
        age_s = self.age_s(now_ns)
        deadline_s = self._topic.deadline_s
        return TopicStatistics(
            topic=self._topic.name,
            source=self._source,
            received=self.received,
            gaps=self.gaps,
            refused=self.refused,
            rate_hz=min(self._rate_hz, 1.0 / age_s) if age_s > 1.0 else self._rate_hz,
            age_s=age_s,
            late=deadline_s is not None and age_s > deadline_s + POLL_S,
        )
