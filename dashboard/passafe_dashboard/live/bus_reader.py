"""Read the bus into the feed, and publish the dashboard's own Health and Events."""

from dataclasses import replace
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Event, Header, Health, LinkConfig, Message
from passafe_protocol.topics import EVENT, HEALTH, LINK_CONFIG, Topic
from passafe_services.loop.bus import Bus
from passafe_services.loop.outlet import Outlet
from passafe_services.loop.pace import Pace
from passafe_services.loop.rate_limited_log import RateLimitedLog

from passafe_dashboard.live.feed import TOPICS_READ, Feed
from passafe_dashboard.live.link_keeper import LinkKeeper
from passafe_dashboard.live.partial_decoding import PARTIAL_DECODERS

HEALTH_PERIOD_NS: Final = 1_000_000_000
QUEUE: Final = 4096
"""Messages of a topic that may wait: 4 s at 1 kHz, since control loops may keep the processors for long."""


class BusReader:
    """Reader of every topic of the feed.

    Args:
        bus: The session.
        feed: Where messages go.
        outlet: Where the dashboard's own Health and Events go.
    """

    def __init__(self, bus: Bus, feed: Feed, outlet: Outlet) -> None:
        self._feed = feed
        self._outlet = outlet
        self._readers = tuple(
            (topic, bus.reader(replace(topic, queue=QUEUE)), PARTIAL_DECODERS.get(topic.name)) for topic in TOPICS_READ
        )
        self._log = RateLimitedLog()
        self._keeper = LinkKeeper(feed.links, self._request_settings, self._report_repetition)
        self._reported_ns: int | None = None
        self._reported_steps = 0
        self._sequences: dict[str, int] = {}

    def read(self, now_ns: int, pace: Pace) -> None:
        """Move what has arrived by ``now_ns`` into the feed; a due Health reports ``pace``.

        Of several ticks or states only the newest is decoded in full: the page shows no other one's details.
        """
        for topic, reader, decode_partially in self._readers:
            arrived = reader.drain()
            if decode_partially is not None:
                for data in arrived[:-1]:
                    partial = decode_partially(data)
                    if partial is None:
                        self._push(topic, data, now_ns)
                    else:
                        self._feed.push_partial(partial[0], partial[1], now_ns)
                del arrived[:-1]
            for data in arrived:
                self._push(topic, data, now_ns)
        self._keeper.step(now_ns)
        if self._reported_ns is None:
            self._reported_ns = now_ns
        elif now_ns - self._reported_ns >= HEALTH_PERIOD_NS:
            self._report_health(now_ns, self._reported_ns, pace)

    def _push(self, topic: Topic, data: bytes, now_ns: int) -> None:
        try:
            header, body = decode(topic, data)
        except ProtocolError as error:
            self._feed.refuse(topic)
            self._report_event(f"refused {topic.name}", "warning", f"refused {error}", now_ns)
        else:
            self._feed.push(header, body, now_ns)

    def _report_health(self, now_ns: int, before_ns: int, pace: Pace) -> None:
        health = Health(
            rate_hz=(pace.steps - self._reported_steps) * 1e9 / (now_ns - before_ns),
            steps=pace.steps,
            overruns=pace.overruns,
            steps_skipped=pace.skipped,
            late_us_max=pace.pop_max_lateness_ns() / 1e3,
            topics=self._feed.health,
        )
        self._reported_ns, self._reported_steps = now_ns, pace.steps
        self._publish(HEALTH, health, now_ns)

    def _request_settings(self, config: LinkConfig, now_ns: int) -> None:
        self._outlet.publish(LINK_CONFIG, config, scheduled_ns=now_ns, started_ns=now_ns)

    def _report_repetition(self, text: str, now_ns: int) -> None:
        self._report_event("link settings", "info", text, now_ns)

    def _report_event(self, kind: str, severity: str, text: str, now_ns: int) -> None:
        event: Event | None = self._log.report(kind, severity, text, now_ns)
        if event is not None:
            self._publish(EVENT, event, now_ns)

    def _publish(self, topic: Topic, body: Message, now_ns: int) -> None:
        """Publish, and push into the feed too: a session does not receive its own messages."""
        self._outlet.publish(topic, body, scheduled_ns=now_ns, started_ns=now_ns)
        sequence = self._sequences.get(topic.name, 0)
        self._sequences[topic.name] = sequence + 1
        header = Header(self._outlet.source, self._outlet.epoch, sequence, now_ns, now_ns, now_ns, 0)
        self._feed.push(header, body, now_ns)
