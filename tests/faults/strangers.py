"""Faults that a stranger or a broken peer sends over the bus, or does to the page."""

import socket
import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from threading import Event, Thread
from time import monotonic_ns, sleep, time_ns

from fault_system import FaultSystem
from passafe_protocol import passafe_pb2
from passafe_protocol.checksum import with_checksum
from passafe_protocol.codec import encode
from passafe_protocol.messages import Header, OperatorCommand, PlantInput, PlantPhase, PlantState
from passafe_protocol.topics import COMMAND, INPUT, STATE, Topic
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint

Injection = Callable[[FaultSystem], AbstractContextManager[None]]

FLOOD_HZ = 20_000
BATCH_S = 0.005
LARGE = 50_000_000

BODIES = {
    COMMAND.name: OperatorCommand((90.0, 90.0), (0.0, 0.0), enabled=True, device="stranger"),
    INPUT.name: PlantInput(1, (90.0, 90.0), 0, 1_000_000_000),
    STATE.name: PlantState(
        0, (0.0,) * 4, (0.0,) * 2, (0.0,) * 2, 0, PlantPhase.RUNNING, 0.0, 0.0, 0, 0, 0, 0.0, 0, -1, 0, 0, 0
    ),
}


def forged(topic: Topic, *, epoch: int, sequence: int = 0) -> bytes:
    """Return a message as its rightful sender would send it, of a session of its own."""
    now = monotonic_ns()
    header = Header(topic.publishers[0], epoch, sequence, now, now, now, time_ns())
    return encode(header, BODIES[topic.name])


def in_background(send: Callable[[Bus, Event], None]) -> Injection:
    """Return the fault that somebody on the bus sends for a while."""

    @contextmanager
    def inject(system: FaultSystem) -> Iterator[None]:
        stop = Event()

        def run() -> None:
            with open_bus(RouterEndpoint(port=system.demo.router_port)) as bus:
                send(bus, stop)

        thread = Thread(target=run)
        thread.start()
        try:
            yield
        finally:
            stop.set()
            thread.join()

    return inject


def flood(topic: Topic) -> Injection:
    """Return the fault of ``FLOOD_HZ`` messages of garbage a second on a topic."""

    def send(bus: Bus, stop: Event) -> None:
        publish = bus.publisher(topic, topic.publishers[0])
        number, start = 0, monotonic_ns()
        while not stop.wait(BATCH_S):
            due = (monotonic_ns() - start) * FLOOD_HZ // 1_000_000_000
            while number < due:
                number += 1
                publish(struct.pack("<Q", number) * 8)

    return in_background(send)


def corrupted(topic: Topic) -> Injection:
    """Return the fault of true messages with one flipped bit, a hundred a second."""

    def send(bus: Bus, stop: Event) -> None:
        publish = bus.publisher(topic, topic.publishers[0])
        number = 0
        while not stop.wait(0.01):
            number += 1
            data = bytearray(forged(topic, epoch=time_ns(), sequence=number))
            data[number % len(data)] ^= 1 << (number % 8)
            publish(bytes(data))

    return in_background(send)


def oversized(topic: Topic) -> Injection:
    """Return the fault of messages of 50 MB."""

    def send(bus: Bus, stop: Event) -> None:
        publish = bus.publisher(topic, topic.publishers[0])
        for _ in range(6):
            publish(bytes(LARGE))
        stop.wait()

    return in_background(send)


def far_future(topic: Topic) -> Injection:
    """Return the fault of well-formed messages of a session with the largest epoch there is."""

    def send(bus: Bus, stop: Event) -> None:
        publish = bus.publisher(topic, topic.publishers[0])
        number = 0
        while not stop.wait(0.01):
            publish(forged(topic, epoch=2**64 - 1, sequence=number))
            number += 1

    return in_background(send)


def other_version(topic: Topic) -> Injection:
    """Return the fault of messages of another schema version."""

    def send(bus: Bus, stop: Event) -> None:
        publish = bus.publisher(topic, topic.publishers[0])
        message = getattr(passafe_pb2, topic.body.__name__)()
        message.header.schema_version = 99
        message.header.source = topic.publishers[0]
        while not stop.wait(0.01):
            publish(with_checksum(message.SerializeToString()))

    return in_background(send)


def many_keys(bus: Bus, stop: Event) -> None:
    """Publish under as many keys as there is time for."""
    session, number = bus._session, 0
    while not stop.wait(BATCH_S):
        for _ in range(100):
            session.put(f"passafe/robot/k{number}/health", b"x")
            number += 1


@contextmanager
def silent_pages(system: FaultSystem) -> Iterator[None]:
    """Open 200 pages at once that read nothing."""
    request = (
        f"GET /live HTTP/1.1\r\nHost: 127.0.0.1:{system.page}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ).encode()
    clients = [socket.create_connection(("127.0.0.1", system.page), 10) for _ in range(200)]
    try:
        for client in clients:
            with suppress(OSError):
                client.sendall(request)
        yield
    finally:
        for client in clients:
            client.close()


def slow_reader(bus: Bus, stop: Event) -> None:
    """Subscribe to everything and read nothing."""
    reader = bus.recording_reader()
    while not stop.wait(0.1):
        sleep(0)
    del reader
