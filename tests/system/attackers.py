"""Sessions with the keys of every role, and what each can try against another's topics."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import zenoh
from passafe_protocol.identity import ROLES, ROUTER
from passafe_protocol.topics import TOPICS, Topic
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.routing import listening_router
from passafe_services.loop.session import client_settings, open_session
from running_demo import free_port

PATIENCE_S = 10.0
ROBOTS = ("left", "right")
WITNESS = 1
FORGED = b"forged"

Sample = tuple[str, bytes]


class Arena:
    """A router with access control, and raw Zenoh sessions that know none of passafe's own checks.

    Attributes:
        keys: The deployment.
        endpoint: Where the router listens, without keys.
    """

    def __init__(self, keys: Path, stack: ExitStack) -> None:
        self.keys = keys
        self.endpoint = RouterEndpoint(port=free_port())
        self._stack = stack
        self._sessions: dict[str, zenoh.Session] = {}
        stack.enter_context(listening_router(self.with_keys(ROUTER)))

    def with_keys(self, role: str, robot: str = "", folder: str = "") -> RouterEndpoint:
        """Return the endpoint with the keys of a role."""
        return replace(self.endpoint, credentials=load_credentials(self.keys / folder, role, robot))

    def session(self, role: str, robot: str, number: int = 0) -> zenoh.Session:
        """Return a session with the keys of a role of a robot, the same at every call.

        A session delivers to itself what the router never sees, so that witnesses have sessions of their own.
        """
        name = f"{role}.{robot} {number}"
        if name not in self._sessions:
            endpoint = self.with_keys(role, robot)
            session = open_session(client_settings(endpoint.locator, endpoint.credentials, PATIENCE_S))
            self._stack.callback(session.close)
            self._sessions[name] = session
        return self._sessions[name]

    def watch(self, robot: str) -> "Watch":
        """Return what a robot's recorder receives: of every key of the robot, its caches included."""
        return Watch(self.session("recorder", robot, WITNESS), robot)


class Watch:
    """Everything that reaches a robot's recorder, deletions too."""

    def __init__(self, session: zenoh.Session, robot: str) -> None:
        self._subscribers = [
            session.declare_subscriber(key, zenoh.handlers.FifoChannel(100_000))
            for key in (f"passafe/{robot}/*/*", f"passafe/{robot}/*/*/@adv/**")
        ]

    def ready(self, put: Callable[[bytes], None]) -> None:
        """Wait until what a sender puts where it may arrives: a declaration takes a moment to get about."""
        end_s = time.monotonic() + PATIENCE_S
        while not any(self._drain()):
            assert time.monotonic() < end_s, "nothing arrives"
            put(b"are you there?")
            time.sleep(0.002)
        self.until(b"now I am", put)

    def until(self, sentinel: bytes, put: Callable[[bytes], None]) -> list[Sample]:
        """Return what came before the sentinel, which ``put`` publishes where its sender may."""
        put(sentinel)
        found: list[Sample] = []
        end_s = time.monotonic() + PATIENCE_S
        while not any(payload == sentinel for _, payload in found):
            assert time.monotonic() < end_s, f"the sentinel {sentinel!r} did not arrive"
            found += self._drain()
            time.sleep(0.001)
        return [sample for sample in found if sample[1] != sentinel]

    def _drain(self) -> list[Sample]:
        samples = [one for subscriber in self._subscribers for one in iter(subscriber.try_recv, None)]
        return [(str(one.key_expr), one.payload.to_bytes()) for one in samples]

    def close(self) -> None:
        """Stop watching."""
        for subscriber in self._subscribers:
            subscriber.undeclare()


def own_key(role: str, robot: str) -> str:
    """Return a key under which a role may publish, for its sentinels."""
    return next(topic for topic in TOPICS if role in topic.publishers).key(role, robot)


def keys_of(topic: Topic, robot: str) -> Iterator[tuple[str, str]]:
    """Yield each publisher of a topic with its key."""
    for publisher in topic.publishers:
        yield publisher, topic.key(publisher, robot)


def wildcards_over(key: str) -> Iterator[str]:
    """Yield wildcard keys that match a key."""
    _, robot, source, topic = key.split("/")
    yield from (
        f"passafe/{robot}/*/{topic}",
        f"passafe/*/{source}/{topic}",
        f"passafe/{robot}/{source}/*",
        f"passafe/{robot}/{source}/{topic[:-1]}$*",
        f"*/{robot}/{source}/{topic}",
        f"passafe/{robot}/**",
        "passafe/**",
        f"**/{topic}",
        "**",
    )


@contextmanager
def arena(folder: Path) -> Iterator[Arena]:
    """Run a router for two robots, with keys for everybody."""
    Deployment.create(folder).issue(identities_of(ROBOTS, ["alice"]))
    with ExitStack() as stack:
        yield Arena(folder, stack)


EVERYBODY = [(role, robot) for robot in ROBOTS for role in ROLES]
