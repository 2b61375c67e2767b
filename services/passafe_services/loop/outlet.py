"""The way of a message out of a process: make it, stamp it, encode it, hand it to the bus."""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic_ns, time_ns

from passafe_protocol.codec import encode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Header, Message, Record
from passafe_protocol.topics import TOPICS, Topic

from passafe_services.loop.bus import Bus, Put
from passafe_services.loop.errors import PublisherError


@dataclass(slots=True)
class _Line:
    """One topic of one process."""

    put: Put
    sequence: int = 0


class Outlet:
    """Publishes for one process, numbering each topic from 0 without gaps.

    Args:
        bus: The session.
        source: Name of the process; it may publish what the table of topics says.
        epoch: Its session number, greater than that of every session of this name before.

    Attributes:
        source: Name of the process.
        epoch: Its session number.
        withheld: Messages that were not valid and therefore not sent.
    """

    def __init__(self, bus: Bus, source: str, epoch: int) -> None:
        self.source = source
        self.epoch = epoch
        self.withheld = 0
        self._lines = {
            topic.name: _Line(bus.publisher(topic, source)) for topic in TOPICS if source in topic.publishers
        }

    def sent(self, topic: Topic) -> int:
        """Messages published on a topic so far, which is the number of the next one."""
        return self._lines[topic.name].sequence

    def publish(
        self, topic: Topic, body: Message | Callable[[], Message], *, scheduled_ns: int, started_ns: int
    ) -> ProtocolError | None:
        """Publish one message.

        Args:
            topic: Where it goes.
            body: The message, or a function that makes it.
            scheduled_ns: When the step that made it was due, monotonic ns.
            started_ns: When it began, monotonic ns.

        Returns:
            ``None``, or why it was withheld: a receiver would refuse it.

        Raises:
            PublisherError: If the table does not let this process publish the topic.
        """
        line = self._lines.get(topic.name)
        if line is None:
            raise PublisherError(self.source, topic.name, topic.publishers)
        message = body if isinstance(body, Record) else body()
        header = Header(self.source, self.epoch, line.sequence, scheduled_ns, started_ns, monotonic_ns(), time_ns())
        try:
            data = encode(header, message)
        except ProtocolError as error:
            self.withheld += 1
            return error
        line.put(data)
        line.sequence += 1
        return None
