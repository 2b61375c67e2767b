"""From the bus into the feed: decodes what has arrived, and tells how the dashboard is doing."""

from dataclasses import replace
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Event, Header, Health, Message
from passafe_protocol.topics import EVENT, HEALTH, Topic
from passafe_services.loop.bus import Bus
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog

from passafe_dashboard.feed import TOPICS_READ, Feed
from passafe_dashboard.thin import THIN_READERS

HEALTH_PERIOD_NS: Final = 1_000_000_000
QUEUE: Final = 4096
"""Messages of a topic that wait for us: 4 s at 1 kHz, since control loops may keep the processors for long."""


class BusPump:
    """Reads every topic of the feed from the bus; made for ``Broadcast``.

    Args:
        bus: The session.
        feed: Where messages go.
        outlet: Where the dashboard's own Health and Events go.
    """

    def __init__(self, bus: Bus, feed: Feed, outlet: Outlet) -> None:
        self._feed = feed
        self._outlet = outlet
        self._readers = tuple(
            (topic, bus.reader(replace(topic, queue=QUEUE)), THIN_READERS.get(topic.name)) for topic in TOPICS_READ
        )
        self._notices = RateLimitedLog()
        self._told_ns: int | None = None
        self._told_steps = 0
        self._own: dict[str, int] = {}

    def __call__(self, now_ns: int, pace: Pace) -> None:
        """Move what has arrived by ``now_ns`` into the feed; ``pace`` is what a due Health tells of."""
        for topic, reader, read_thin in self._readers:
            arrived = reader.drain()
            if read_thin is not None:
                for data in arrived[:-1]:
                    thin = read_thin(data)
                    if thin is None:
                        self._take(topic, data, now_ns)
                    else:
                        self._feed.glance(thin[0], thin[1], now_ns)
                del arrived[:-1]
            for data in arrived:
                self._take(topic, data, now_ns)
        if self._told_ns is None:
            self._told_ns = now_ns
        elif now_ns - self._told_ns >= HEALTH_PERIOD_NS:
            self._tell_health(now_ns, self._told_ns, pace)

    def _take(self, topic: Topic, data: bytes, now_ns: int) -> None:
        try:
            header, body = decode(topic, data)
        except ProtocolError as error:
            self._feed.refuse(topic)
            self._say(f"refused {topic.name}", "warning", f"refused {error}", now_ns)
        else:
            self._feed.push(header, body, now_ns)

    def _tell_health(self, now_ns: int, before_ns: int, pace: Pace) -> None:
        health = Health(
            rate_hz=(pace.steps - self._told_steps) * 1e9 / (now_ns - before_ns),
            steps=pace.steps,
            overruns=pace.overruns,
            steps_skipped=pace.missed,
            late_us_max=pace.take_worst_late_ns() / 1e3,
            topics=self._feed.health,
        )
        self._told_ns, self._told_steps = now_ns, pace.steps
        self._publish(HEALTH, health, now_ns)

    def _say(self, kind: str, severity: str, text: str, now_ns: int) -> None:
        event: Event | None = self._notices.notice(kind, severity, text, now_ns)
        if event is not None:
            self._publish(EVENT, event, now_ns)

    def _publish(self, topic: Topic, body: Message, now_ns: int) -> None:
        """Publish, and show it on the page too: a session does not hear itself."""
        self._outlet.publish(topic, body, scheduled_ns=now_ns, started_ns=now_ns)
        sequence = self._own.get(topic.name, 0)
        self._own[topic.name] = sequence + 1
        header = Header(self._outlet.source, self._outlet.epoch, sequence, now_ns, now_ns, now_ns, 0)
        self._feed.push(header, body, now_ns)
