"""A servo over UDP against a peer that answers late, wrong, twice and not at all."""

import socket
import threading
from collections.abc import Iterator
from contextlib import suppress
from struct import pack
from zlib import crc32

import pytest
from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.servo_clock import DRIFT, ServoClock
from passafe_services.drivers.servo_frames import ASK, MOVE, STOP, ServoAnswer, ServoCommand, ServoFrames
from passafe_services.drivers.udp_servo import MOST_AT_ONCE, UdpServo
from passafe_services.scenarios.driver_schema import UdpServoConfig

MS = 1_000_000
FRAMES = ServoFrames(1)
LARGEST = (10.0, 10.0)


class Peer:
    """A servo that answers when a test wants it."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(5)
        self.sender = ("", 0)

    def receive(self) -> ServoCommand:
        datagram, self.sender = self.socket.recvfrom(2048)
        command = FRAMES.command_of(datagram)
        assert command is not None
        return command

    def send(self, *datagrams: bytes) -> None:
        for datagram in datagrams:
            self.socket.sendto(datagram, self.sender)

    def answer(self, number: int, servo_ms: float, *x: float) -> bytes:
        return FRAMES.answer(ServoAnswer(number, round(servo_ms * MS), x))


class Clock:
    """Time as a test sets it."""

    def __init__(self) -> None:
        self.now_ns = 1_000 * MS

    def __call__(self) -> int:
        return self.now_ns


@pytest.fixture
def peer() -> Iterator[Peer]:
    made = Peer()
    yield made
    made.socket.close()


@pytest.fixture
def clock() -> Clock:
    return Clock()


def servo_at(peer: Peer, clock: Clock) -> UdpServo:
    port = peer.socket.getsockname()[1]
    return UdpServo(UdpServoConfig(kind="udp-servo", port=port), 1, LARGEST, clock=clock)


@pytest.fixture
def servo(peer: Peer, clock: Clock) -> Iterator[UdpServo]:
    made = servo_at(peer, clock)

    def first() -> None:
        peer.send(peer.answer(peer.receive().number, 500, 0.5, 0.0))

    thread = threading.Thread(target=first)
    thread.start()
    made.open()
    thread.join()
    yield made
    made.close()


def moved(servo: UdpServo, peer: Peer, u: float) -> int:
    """Apply an input and return the number of its command, as it is received."""
    servo.apply((u,), 0)
    command = peer.receive()
    while command.kind != MOVE:  # further questions of open()
        command = peer.receive()
    assert command.u == (u,)
    return command.number


def x_of(servo: UdpServo) -> tuple[float, ...]:
    reading = servo.read(0)
    assert reading is not None
    return reading.x


def test_it_reads_what_it_is_answered(servo: UdpServo, peer: Peer, clock: Clock) -> None:
    number = moved(servo, peer, 2.0)
    clock.now_ns += MS
    peer.send(peer.answer(number, 501, 0.6, 0.1))

    reading = servo.read(0)

    assert reading is not None
    assert (reading.x, reading.at_ns) == ((0.6, 0.1), clock.now_ns)


def test_it_asks_for_the_state_before_anything_is_applied(servo: UdpServo, peer: Peer, clock: Clock) -> None:
    servo.read(0)
    command = peer.receive()
    while command.number < servo._number:  # further questions of open()
        command = peer.receive()
    assert command.kind == ASK
    clock.now_ns += MS
    peer.send(peer.answer(command.number, 501, 0.7, 0.1))

    assert x_of(servo) == (0.7, 0.1)


def test_a_late_answer_is_given_its_own_time(servo: UdpServo, peer: Peer, clock: Clock) -> None:
    number = moved(servo, peer, 2.0)
    clock.now_ns += 31 * MS
    peer.send(peer.answer(number, 501, 0.6, 0.1))

    reading = servo.read(0)

    assert reading is not None
    assert clock.now_ns - reading.at_ns == pytest.approx(30 * MS, abs=DRIFT * 31 * MS + 1)


def test_one_that_was_overtaken_is_not_the_present(servo: UdpServo, peer: Peer) -> None:
    first, second = moved(servo, peer, 1.0), moved(servo, peer, 2.0)
    peer.send(peer.answer(second, 502, 0.8, 0.2), peer.answer(first, 501, 0.6, 0.1))

    assert x_of(servo) == (0.8, 0.2)
    assert servo.repeated == 1


def test_an_answer_that_comes_twice_counts_once(servo: UdpServo, peer: Peer, clock: Clock) -> None:
    number = moved(servo, peer, 1.0)
    answer = peer.answer(number, 501, 0.6, 0.1)
    peer.send(answer)
    before = servo.read(0)
    clock.now_ns += 20 * MS
    peer.send(answer, answer)

    assert servo.read(0) == before
    assert servo.repeated == 2


def test_wrong_answers_change_nothing(servo: UdpServo, peer: Peer) -> None:
    number = moved(servo, peer, 1.0)
    right = peer.answer(number, 501, 0.6, 0.1)
    flipped = bytes([*right[:20], right[20] ^ 1, *right[21:]])
    foreign = pack("<4sIQ2d", b"PSX1", number, 501 * MS, 0.6, 0.1)
    peer.send(
        b"",
        b"noise",
        right + b"more",
        flipped,
        foreign + pack("<I", crc32(foreign)),
        peer.answer(number, 501, float("nan"), 0.1),
        peer.answer(number, 501, 0.6, 10.5),
        peer.answer(number + 1, 501, 0.6, 0.1),
        peer.answer(0, 501, 0.6, 0.1),
    )

    assert x_of(servo) == (0.5, 0.0)
    assert servo.refused == 9
    peer.send(right)
    assert x_of(servo) == (0.6, 0.1)


def test_no_answer_leaves_the_last_state_with_its_time(servo: UdpServo, peer: Peer, clock: Clock) -> None:
    opened_ns = clock.now_ns
    moved(servo, peer, 1.0)
    clock.now_ns += 200 * MS

    reading = servo.read(0)

    assert reading is not None
    assert reading.at_ns == opened_ns


def test_a_flood_takes_one_period_no_longer(servo: UdpServo, peer: Peer) -> None:
    moved(servo, peer, 1.0)
    peer.send(*[b"noise"] * (MOST_AT_ONCE + 20))

    servo.read(0)
    assert servo.refused == MOST_AT_ONCE


def test_it_is_asked_to_stop_when_it_is_closed(servo: UdpServo, peer: Peer) -> None:
    moved(servo, peer, 1.0)
    servo.close()
    servo.close()

    assert peer.receive().kind == STOP
    with pytest.raises(DriverError, match="driver udp-servo: got a servo that is not open"):
        servo.read(0)


def test_a_silent_servo_cannot_be_opened(peer: Peer, clock: Clock) -> None:
    made = servo_at(peer, clock)

    def late() -> None:
        with suppress(TimeoutError):
            peer.receive()
        clock.now_ns += 3_000 * MS

    thread = threading.Thread(target=late)
    thread.start()
    with pytest.raises(DriverError, match=r"no answer from 127.0.0.1:\d+ within 2 s, allowed a servo that answers"):
        made.open()
    thread.join()


def test_a_host_without_an_address_is_refused(clock: Clock) -> None:
    config = UdpServoConfig(kind="udp-servo", host="256.0.0.1", port=9)
    with pytest.raises(DriverError, match=r"256\.0\.0\.1:9"):
        UdpServo(config, 1, LARGEST, clock=clock).open()


def test_a_peer_that_went_away_is_no_exception(servo: UdpServo, peer: Peer) -> None:
    peer.socket.close()
    for _ in range(5):
        servo.apply((1.0,), 0)
        assert x_of(servo) == (0.5, 0.0)


def test_the_quickest_answer_sets_the_clock() -> None:
    clock = ServoClock()

    assert clock.time_of(0, 105 * MS) == 105 * MS
    assert clock.time_of(10 * MS, 112 * MS) == 112 * MS
    slow = clock.time_of(20 * MS, 150 * MS)

    assert slow == pytest.approx(122 * MS, abs=DRIFT * 38 * MS + 1)


def test_frames_are_read_as_they_were_written() -> None:
    command, answer = ServoCommand(7, MOVE, (1.5,)), ServoAnswer(7, 8, (1.0, -2.0))

    assert FRAMES.command_of(FRAMES.command(command)) == command
    assert FRAMES.answer_of(FRAMES.answer(answer)) == answer
    assert FRAMES.answer_of(FRAMES.command(command)) is None
    assert FRAMES.command_of(FRAMES.answer(answer)) is None
