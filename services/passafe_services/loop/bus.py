"""Bus: a Zenoh session that is a client of the router.

A publisher caches its messages for a while, and the recorder requests those that it missed, so a log is complete
although control traffic is dropped on congestion. Readers are polled ring buffers: a callback would need a Python
thread that competes with the control loop.
"""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from itertools import islice
from typing import Final

import zenoh
from passafe_protocol.keys import DEFAULT_ROBOT, key_of
from passafe_protocol.topics import Congestion, Priority, Topic
from zenoh import ext, handlers

from passafe_services.keys.credentials import Credentials
from passafe_services.keys.errors import KeysMismatchError
from passafe_services.loop.admission import Admission
from passafe_services.loop.errors import BusError, PublisherError, RoleError
from passafe_services.loop.handshake import refusal_of
from passafe_services.loop.recording_reader import CACHED_SAMPLES, RECORDING_QUEUE, RecordingReader
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.session import client_settings, open_session

HEARTBEAT_S: Final = 0.5
"""Interval at which a publisher says how far it has come, so that the loss of its last message is detected."""

_CONGESTION: Final = {
    Congestion.DROP: zenoh.CongestionControl.DROP,
    Congestion.BLOCK: zenoh.CongestionControl.BLOCK,
}

_PRIORITY: Final = {Priority.REAL_TIME: zenoh.Priority.REAL_TIME, Priority.DATA: zenoh.Priority.DATA}

PublishBytes = Callable[[bytes], None]


class TopicReader:
    """Ring buffer of the newest messages of one topic, oldest first."""

    def __init__(self, subscriber: zenoh.Subscriber[handlers.Handler[zenoh.Sample]], capacity: int) -> None:
        self._subscriber = subscriber
        self._capacity = capacity

    def drain(self, at_most: int | None = None) -> list[bytes]:
        """Return the oldest payloads received since the last call.

        Args:
            at_most: How many; ``None``: one ring full, so that the call is bounded.
        """
        samples = islice(iter(self._subscriber.try_recv, None), at_most or self._capacity)
        return [sample.payload.to_bytes() for sample in samples]


class Bus:
    """Open session of a process of one robot; created by ``open_bus``."""

    def __init__(
        self, session: zenoh.Session, robot: str, credentials: Credentials | None = None, locator: str = ""
    ) -> None:
        self._robot = robot
        self._identity = None if credentials is None else credentials.identity
        self._admission = None if self._identity is None else Admission(session, self._identity, locator)
        self._session = session
        self._recording_readers: list[RecordingReader] = []
        self._replies = ext.RepliesConfig(
            congestion_control=zenoh.CongestionControl.BLOCK, priority=zenoh.Priority.BACKGROUND
        )

    @property
    def connected(self) -> bool:
        """True while a router is connected that admits this process; the session reconnects by itself."""
        return bool(self.router) and not self.refusal

    @property
    def router(self) -> str:
        """Identity of the connected router, which changes with its restart; empty without one."""
        return " ".join(str(zid) for zid in self._session.info.routers_zid())

    @property
    def refusal(self) -> str:
        """Reason for which the connected router drops what this process publishes; empty if it does not."""
        return "" if self._admission is None else self._admission.refusal(self.router)

    def require_admission(self, timeout_s: float) -> None:
        """Check that the router admits this process, if it has keys.

        Raises:
            NotAdmittedError: It does not, or not for all that the role publishes.
            OpenRouterError: It lets everybody do everything.
        """
        if self._admission is not None:
            self._admission.require(self.router, timeout_s)

    def publisher(self, topic: Topic, source: str) -> PublishBytes:
        """Return a function that publishes bytes on a topic; it never raises, also without a reader.

        Raises:
            PublisherError: ``source`` may not publish the topic.
            RoleError: The keys of this session are of another role; the router would drop the messages silently.
        """
        if source not in topic.publishers:
            raise PublisherError(source, topic.name, topic.publishers)
        if self._identity is not None and self._identity.role != source:
            raise RoleError(topic.name, self._identity.common_name, source)
        congestion, priority = _CONGESTION[topic.congestion], _PRIORITY[topic.priority]
        if not topic.recorded:
            return self._session.declare_publisher(
                topic.key(source, self._robot), congestion_control=congestion, priority=priority
            ).put
        return ext.declare_advanced_publisher(
            self._session,
            topic.key(source, self._robot),
            congestion_control=congestion,
            priority=priority,
            cache=ext.CacheConfig(max_samples=CACHED_SAMPLES, replies_config=self._replies),
            sample_miss_detection=ext.MissDetectionConfig(heartbeat=HEARTBEAT_S, sporadic_heartbeat=None),
        ).put

    def reader(self, topic: Topic) -> TopicReader:
        """Return a reader of what other sessions publish on a topic."""
        subscriber = self._session.declare_subscriber(
            topic.selector(self._robot),
            handlers.RingChannel(topic.queue),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        return TopicReader(subscriber, topic.queue)

    def recording_reader(self) -> RecordingReader:
        """Return a reader of all topics of the robot, for the recorder."""
        self._recording_readers.append(
            RecordingReader(
                self._session,
                ext.declare_advanced_subscriber(
                    self._session,
                    key_of(self._robot, "*", "*"),
                    handlers.FifoChannel(RECORDING_QUEUE),
                    recovery=ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
                ),
            )
        )
        return self._recording_readers[-1]

    def close(self) -> None:
        """End the session, the recording readers first: a session blocked by a full one would not end."""
        for reader in self._recording_readers:
            reader.end()
        close: Callable[[], None] = self._session.close  # likewise
        close()


@contextmanager
def open_bus(endpoint: RouterEndpoint, *, robot: str = DEFAULT_ROBOT, timeout_s: float = 5.0) -> Iterator[Bus]:
    """Open a session with the router at ``endpoint`` and close it at the end of the block.

    If the router disappears later, published messages are lost and readers receive nothing until it is back; nothing
    raises.

    Args:
        endpoint: Address of the router, and the keys with which to open the session.
        robot: Robot whose topics are published and read.
        timeout_s: Connection timeout, s. Ctrl-C takes effect after it.

    Raises:
        BusError: No router answers within ``timeout_s``, or it refuses the keys.
        KeysMismatchError: The keys are those of another robot.
        NotAdmittedError: The router would drop what this process publishes.
        OpenRouterError: The router has no access control.
    """
    credentials = endpoint.credentials
    if credentials is not None and credentials.identity.robot not in {robot, ""}:
        raise KeysMismatchError(credentials.folder.path, credentials.identity.common_name, f"one for robot {robot}")
    try:
        session = open_session(client_settings(endpoint.locator, credentials, timeout_s))
    except zenoh.ZError as error:
        reason = refusal_of(endpoint) or f"no router answered within {timeout_s:g} s"
        raise BusError(endpoint.locator, reason) from error
    with closing(Bus(session, robot, credentials, endpoint.locator)) as bus:
        bus.require_admission(timeout_s)
        yield bus
