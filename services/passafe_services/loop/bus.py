"""The bus: a Zenoh session that is a client of the router.

Every put of a publisher is kept in its cache for a while, and the log reader asks for what it missed, so a
log is complete although control traffic is dropped on congestion. Readers are rings that are polled: a
callback would need a Python thread that competes with the control loop.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from typing import Final

import zenoh
from passafe_protocol.topics import KEY_ROOT, Congestion, Topic
from zenoh import ext, handlers

from passafe_services.loop.errors import BusError, PublisherError
from passafe_services.loop.router_endpoint import RouterEndpoint

LEASE_MS: Final = 500
"""A session that was silent for so long is closed: what queued up for it is lost, not delivered late."""

CACHED_SAMPLES: Final = 16_384
"""What a publisher keeps for the recorder: 16 s at 1 kHz, longer than a router takes to be started again."""

HEARTBEAT_S: Final = 0.5
"""How soon after the last put of a series its loss is noticed."""

LOG_QUEUE: Final = 16_384
"""Capacity of a log reader. A full one blocks the session, which the publishers' caches then make good."""

_SHARED_SETTINGS: Final[dict[str, object]] = {
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": False,
    "timestamping/enabled": False,
    "transport/shared_memory/enabled": False,
    "transport/link/tx/lease": LEASE_MS,
    # Batches of 64 KiB. What does not fit at once is dropped: the first tick of a filter that waited for its plant
    # tells of every command since its start, some 30 B each.
    "transport/link/tx/queue/size/data": 16,
    # µs. A full queue means a peer that stands still; a control loop must not stand still with it.
    "transport/link/tx/queue/congestion_control/drop/wait_before_drop": 0,
    "transport/link/tx/queue/congestion_control/block/wait_before_close": 500_000,
}
"""Settings of every session, router and clients alike."""

_CONGESTION: Final = {
    Congestion.DROP: zenoh.CongestionControl.DROP,
    Congestion.BLOCK: zenoh.CongestionControl.BLOCK,
}

Put = Callable[[bytes], None]


class Reader:
    """A ring of the newest messages of one topic, oldest first out."""

    def __init__(self, subscriber: zenoh.Subscriber[handlers.Handler[zenoh.Sample]], capacity: int) -> None:
        self._subscriber = subscriber
        self._capacity = capacity

    def drain(self) -> list[bytes]:
        """Payloads that came since the last call; at most a ring full, so a fast sender cannot hold us."""
        taken: list[bytes] = []
        try_recv = self._subscriber.try_recv
        for _ in range(self._capacity):
            sample = try_recv()
            if sample is None:
                break
            taken.append(sample.payload.to_bytes())
        return taken


class RecordingReader:
    """Every message of every topic, without loss as long as the publishers' caches reach back.

    Also what was put while there was no router between them; not what a publisher put before the reader knew of it.
    """

    def __init__(self, subscriber: ext.AdvancedSubscriber[handlers.Handler[zenoh.Sample]]) -> None:
        self._subscriber = subscriber

    def end(self) -> None:
        """Read no more: what waits is dropped."""
        undeclare: Callable[[], None] = self._subscriber.undeclare  # without types in its stub
        undeclare()

    def drain(self) -> list[tuple[str, bytes]]:
        """Key expressions and payloads that came since the last call; those of one publisher in order."""
        taken: list[tuple[str, bytes]] = []
        try_recv = self._subscriber.try_recv
        for _ in range(LOG_QUEUE):
            sample = try_recv()
            if sample is None:
                break
            taken.append((str(sample.key_expr), sample.payload.to_bytes()))
        return taken


class Bus:
    """An open session; made by ``open_bus``."""

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._log_readers: list[RecordingReader] = []
        self._replies = ext.RepliesConfig(
            congestion_control=zenoh.CongestionControl.BLOCK, priority=zenoh.Priority.BACKGROUND
        )

    @property
    def connected(self) -> bool:
        """Whether there is a router now; the session looks for it again by itself."""
        return bool(self.router)

    @property
    def router(self) -> str:
        """Which router there is now: another text for one that was started again, empty without any."""
        return " ".join(str(zid) for zid in self._session.info.routers_zid())

    def publisher(self, topic: Topic, source: str) -> Put:
        """Function that publishes bytes on a topic; it neither raises nor tells whether somebody reads.

        Raises:
            PublisherError: If the table does not let ``source`` publish the topic.
        """
        if source not in topic.publishers:
            raise PublisherError(source, topic.name, topic.publishers)
        congestion = _CONGESTION[topic.congestion]
        if not topic.recorded:
            return self._session.declare_publisher(topic.key(source), congestion_control=congestion).put
        return ext.declare_advanced_publisher(
            self._session,
            topic.key(source),
            congestion_control=congestion,
            cache=ext.CacheConfig(max_samples=CACHED_SAMPLES, replies_config=self._replies),
            sample_miss_detection=ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=HEARTBEAT_S),
        ).put

    def reader(self, topic: Topic) -> Reader:
        """Ring of what other sessions publish on a topic."""
        subscriber = self._session.declare_subscriber(
            topic.selector,
            handlers.RingChannel(topic.queue),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        return Reader(subscriber, topic.queue)

    def log_reader(self) -> RecordingReader:
        """Reader of everything, for a recorder."""
        self._log_readers.append(
            RecordingReader(
                ext.declare_advanced_subscriber(
                    self._session,
                    f"{KEY_ROOT}/*/*",
                    handlers.FifoChannel(LOG_QUEUE),
                    recovery=ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
                )
            )
        )
        return self._log_readers[-1]

    def close(self) -> None:
        """End the session, the log readers first: a session that waits for room in a full one does not end."""
        for reader in self._log_readers:
            reader.end()
        close: Callable[[], None] = self._session.close  # likewise
        close()


@contextmanager
def open_bus(endpoint: RouterEndpoint, *, timeout_s: float = 5.0) -> Iterator[Bus]:
    """Session with the router at ``endpoint``, closed whatever happens.

    When the router goes away later, puts are lost and readers silent until it is back; nothing raises.

    Args:
        endpoint: Where the router listens.
        timeout_s: How long to look for it. Ctrl-C waits for the end of that search.

    Raises:
        BusError: If there is no router within ``timeout_s``.
    """
    settings = _SHARED_SETTINGS | {
        "mode": "client",
        "connect/endpoints": [endpoint.locator],
        "connect/timeout_ms": round(1e3 * timeout_s),
        "connect/retry": {"period_init_ms": 50, "period_max_ms": 200, "period_increase_factor": 2},
    }
    try:
        session = _open(settings)
    except zenoh.ZError as error:
        raise BusError(endpoint.locator, f"no router answered within {timeout_s:g} s") from error
    with closing(Bus(session)) as bus:
        yield bus


@contextmanager
def listening_router(endpoint: RouterEndpoint) -> Iterator[None]:
    """Router that listens at ``endpoint`` and passes on what its clients publish, until the block ends.

    Raises:
        BusError: If it cannot listen there.
    """
    settings = _SHARED_SETTINGS | {
        "mode": "router",
        "listen/endpoints": [endpoint.locator],
        "adminspace/enabled": False,
    }
    try:
        session = _open(settings)
    except zenoh.ZError as error:
        reason, _, _ = str(error).partition(" at /")  # the rest are places in Zenoh's source
        raise BusError(endpoint.locator, reason) from error
    with closing(session):
        yield


def _open(settings: Mapping[str, object]) -> zenoh.Session:
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)
