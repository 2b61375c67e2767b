"""Several robots under one router, and two linked routers: messages stay with their robot."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from itertools import permutations
from pathlib import Path

import pytest
from passafe_protocol.identity import ROUTER, Identity
from passafe_protocol.topics import COMMAND, INPUT, STATE
from passafe_services.keys.credentials import Credentials, load_credentials
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.routing import listening_router
from running_demo import free_port

pytestmark = pytest.mark.live

PATIENCE_S = 10.0
ROBOTS = ("arm-1", "arm-2", "arm-3", "arm-4", "arm-5")


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    Deployment.create(tmp_path / "keys").issue(identities_of(ROBOTS, routers=["", "site-b"]))
    return tmp_path / "keys"


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as made:
        yield made


def router(keys: Path, stack: ExitStack, name: str = ROUTER, linked: tuple[RouterEndpoint, ...] = ()) -> RouterEndpoint:
    endpoint = RouterEndpoint(port=free_port(), credentials=load_credentials(keys / name, ROUTER))
    stack.enter_context(listening_router(endpoint, linked))
    return endpoint


def bus(keys: Path, stack: ExitStack, at: RouterEndpoint, role: str, robot: str) -> Bus:
    endpoint = RouterEndpoint(port=at.port, credentials=load_credentials(keys, role, robot))
    return stack.enter_context(open_bus(endpoint, robot=robot))


def collect(drain: Callable[[], list[bytes]], put: Callable[[bytes], None], data: bytes) -> set[bytes]:
    """Return all that was received until what is put arrives."""
    found: set[bytes] = set()
    end_s = time.monotonic() + PATIENCE_S
    while data not in found:
        assert time.monotonic() < end_s
        put(data)
        time.sleep(0.005)
        found |= {*drain()}
    return found


def test_five_robots_receive_their_own_messages_alone(keys: Path, stack: ExitStack) -> None:
    at = router(keys, stack)
    plants = {robot: bus(keys, stack, at, "plant", robot) for robot in ROBOTS}
    filters = {robot: bus(keys, stack, at, "filter", robot) for robot in ROBOTS}
    inputs = {robot: one.reader(INPUT) for robot, one in plants.items()}
    puts = {robot: one.publisher(INPUT, "filter") for robot, one in filters.items()}
    logs = {robot: bus(keys, stack, at, "recorder", robot).recording_reader() for robot in ROBOTS}

    received = {robot: collect(inputs[robot].drain, puts[robot], robot.encode()) for robot in ROBOTS}
    for robot in ROBOTS:  # once more, now that everybody is known to receive
        received[robot] |= collect(inputs[robot].drain, puts[robot], robot.encode())

    for own, other in permutations(ROBOTS, 2):
        assert other.encode() not in received[own]
    recorded = {robot: {key for key, _ in log.drain()} for robot, log in logs.items()}
    assert recorded == {robot: {f"passafe/{robot}/filter/input"} for robot in ROBOTS}


@pytest.mark.alone
def test_a_flood_of_one_robot_does_not_delay_another(keys: Path, stack: ExitStack) -> None:
    at = router(keys, stack)
    flood = bus(keys, stack, at, "operator", "arm-1").publisher(COMMAND, "operator")
    swamped = bus(keys, stack, at, "filter", "arm-1").reader(COMMAND)
    put = bus(keys, stack, at, "plant", "arm-2").publisher(STATE, "plant")
    reader = bus(keys, stack, at, "filter", "arm-2").reader(STATE)
    collect(reader.drain, put, b"ready")
    arrived, payload = 0, b"x" * 200
    for number in range(200):  # one second at 200 Hz, with 4,000 messages of the other robot
        put(number.to_bytes(4))
        for _ in range(20):
            flood(payload)
        time.sleep(0.005)
        arrived += sum(len(data) == 4 for data in reader.drain())
    end_s = time.monotonic() + 1.0
    while arrived < 200 and time.monotonic() < end_s:
        arrived += sum(len(data) == 4 for data in reader.drain())

    assert arrived == 200
    assert swamped.drain()


def test_two_linked_routers_serve_one_robot_across_sites(keys: Path, stack: ExitStack) -> None:
    site_a = router(keys, stack)
    site_b = router(keys, stack, "router.site-b", (RouterEndpoint(port=site_a.port, credentials=_b(keys)),))
    put = bus(keys, stack, site_a, "operator", "arm-3").publisher(COMMAND, "operator")
    reader = bus(keys, stack, site_b, "filter", "arm-3").reader(COMMAND)
    other = bus(keys, stack, site_b, "filter", "arm-4").reader(COMMAND)
    log = bus(keys, stack, site_b, "recorder", "arm-3").recording_reader()

    collect(reader.drain, put, b"across")
    assert other.drain() == []
    assert {key for key, _ in log.drain()} <= {"passafe/arm-3/operator/command"}


def test_a_linked_router_lets_in_what_its_own_keys_permit(keys: Path, stack: ExitStack) -> None:
    site_a = router(keys, stack)
    site_b = router(keys, stack, "router.site-b", (RouterEndpoint(port=site_a.port, credentials=_b(keys)),))
    endpoint = RouterEndpoint(port=site_b.port, credentials=load_credentials(keys, "operator", "arm-3"))
    crossing = stack.enter_context(open_bus(endpoint, robot="arm-3"))
    reader = bus(keys, stack, site_a, "plant", "arm-3").reader(INPUT)
    witness = bus(keys, stack, site_a, "filter", "arm-3").reader(COMMAND)
    for key in ("passafe/arm-3/filter/input", "passafe/*/filter/input", "passafe/**"):
        crossing._session.put(key, b"forged")

    collect(witness.drain, crossing.publisher(COMMAND, "operator"), b"mine")
    assert reader.drain() == []
    assert Identity(role=ROUTER, name="site-b") in load_credentials(keys / "router", ROUTER).folder.read_admitted()


def _b(keys: Path) -> Credentials:
    """Return the keys with which site b connects."""
    return load_credentials(keys / "router.site-b", ROUTER)
