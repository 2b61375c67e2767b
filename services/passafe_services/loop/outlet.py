"""Outlet of a process: stamps and encodes its messages and hands them to the bus."""

from collections.abc import Callable
from dataclasses import dataclass
from time import monotonic_ns, time_ns

from passafe_protocol.codec import encode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Header, Health, Message, Record
from passafe_protocol.topics import TOPIC_OF_NAME, TOPICS, Topic

from passafe_services.loop.bus import Bus, PublishBytes
from passafe_services.loop.errors import PublisherError
from passafe_services.loop.health_report import HealthReporter
from passafe_services.loop.monotonic_clock import monotonic_clock_id


@dataclass(slots=True)
class _Channel:
    """Publisher of one topic and the number of its next message."""

    publish: PublishBytes
    sequence: int = 0


class Outlet:
    """Publishes for one process, numbering each topic from 0 without gaps.

    Args:
        bus: The session.
        source: Name of the process; the table of topics lists what it may publish.
        epoch: Session number, another than that of every other session of this process.
        health: Reports the health that the process publishes, also to what supervises it.

    Attributes:
        source: Name of the process.
        epoch: Session number.
        withheld: Invalid messages, which were not sent.
    """

    def __init__(self, bus: Bus, source: str, epoch: int, health: HealthReporter | None = None) -> None:
        self.source = source
        self.epoch = epoch
        self.withheld = 0
        self._bus = bus
        self._health = health
        self._clock_id = monotonic_clock_id()
        self._channels = {
            topic.name: _Channel(bus.publisher(topic, source)) for topic in TOPICS if source in topic.publishers
        }

    def sent(self, topic: Topic) -> int:
        """Return the number of messages published on a topic, which is the sequence number of the next one."""
        return self._channels[topic.name].sequence

    def newest_recorded(self) -> dict[str, int]:
        """Return the sequence number of the last message of each topic that is recorded, by name of the topic."""
        return {
            name: channel.sequence - 1
            for name, channel in self._channels.items()
            if channel.sequence and TOPIC_OF_NAME[name].recorded
        }

    def publish(
        self, topic: Topic, body: Message | Callable[[], Message], *, scheduled_ns: int, started_ns: int
    ) -> ProtocolError | None:
        """Publish one message.

        Args:
            topic: Its topic.
            body: The message, or a function that returns it.
            scheduled_ns: Time at which its step was due, monotonic, ns.
            started_ns: Time at which its step began, monotonic, ns.

        Returns:
            ``None``, or the error for which it was withheld: a receiver would refuse it.

        Raises:
            PublisherError: This process may not publish the topic.
        """
        channel = self._channels.get(topic.name)
        if channel is None:
            raise PublisherError(self.source, topic.name, topic.publishers)
        message = body if isinstance(body, Record) else body()
        if isinstance(message, Health) and self._health is not None:
            self._health.report(connected=self._bus.connected, steps=message.steps, skipped=message.steps_skipped)
        times = (scheduled_ns, started_ns, monotonic_ns(), time_ns())
        header = Header(self.source, self.epoch, channel.sequence, *times, self._clock_id)
        try:
            data = encode(header, message)
        except ProtocolError as error:
            self.withheld += 1
            return error
        channel.publish(data)
        channel.sequence += 1
        return None
