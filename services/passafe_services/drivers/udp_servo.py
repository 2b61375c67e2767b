"""A small servo on the network, by UDP: the worked example of a driver for hardware (``docs/how-to/own-driver.md``).

The plant node sends one command a period and takes what has arrived meanwhile; it never waits. Of the answers only
those count that are whole, of this session, and newer than all before: a late one is not the present, one that comes
twice is old the second time, and one without sense is none. What the newest says is given with its own time, so that
the node sees an answer that does not come as a state that grows old.
"""

import select
import socket
from collections.abc import Callable
from time import monotonic_ns
from typing import Final

from passafe_protocol.messages import Vector

from passafe_services.drivers.errors import DriverError
from passafe_services.drivers.plant_driver import Reading
from passafe_services.drivers.servo_clock import ServoClock
from passafe_services.drivers.servo_frames import ASK, MOVE, STOP, ServoAnswer, ServoCommand, ServoFrames
from passafe_services.scenarios.driver_schema import UdpServoConfig

NAME: Final = "udp-servo"

MOST_AT_ONCE: Final = 64
"""Datagrams taken in one period: a flood must not take the node's time."""

LONGEST_DATAGRAM: Final = 2048


class UdpServo:
    """Reads and moves a servo over UDP.

    Attributes:
        has_own_clock: True: it moves while nobody asks.
        refused: Datagrams that were no whole answer of this session, or whose numbers lie outside the range.
        repeated: Answers that were not newer than one before.
        unsent: Commands that the network did not take.
    """

    has_own_clock = True

    def __init__(
        self, config: UdpServoConfig, axes: int, largest: Vector, *, clock: Callable[[], int] = monotonic_ns
    ) -> None:
        """Hold what is needed to open it.

        Args:
            config: Part of a scenario, or of the command line.
            axes: Number of axes m.
            largest: Largest magnitude of each position and rate that is believed, 2m numbers.
            clock: The plant node's clock, ns.
        """
        self._config, self._axes, self._largest, self._clock = config, axes, largest, clock
        self._frames, self._times = ServoFrames(axes), ServoClock()
        self._socket: socket.socket | None = None
        self._number = self._answered = 0
        self._has_asked = False
        self._newest_ns = -1
        self._newest: Reading | None = None
        self.refused = self.repeated = self.unsent = 0

    def open(self) -> None:
        """Ask for the state until the servo answers.

        Raises:
            DriverError: It does not answer in time, or has no such address.
        """
        place = f"{self._config.host}:{self._config.port}"
        self._socket = made = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        made.setblocking(False)
        try:
            made.connect((self._config.host, self._config.port))
        except OSError as error:
            self.close()
            raise DriverError(NAME, f"{place}: {error.strerror}", "the address of a servo") from error
        end_ns = self._clock() + round(self._config.timeout_s * 1e9)
        while self._newest is None:
            if self._clock() >= end_ns:
                self.close()
                got = f"no answer from {place} within {self._config.timeout_s:g} s"
                raise DriverError(NAME, got, "a servo that answers")
            self._send(ASK, (0.0,) * self._axes)
            select.select([made], [], [], 0.02)
            self._take_answers()

    def read(self, at_ns: int) -> Reading | None:
        """Return the newest trusted state with the time at which it was measured, however old that is.

        A servo speaks only when it is asked: where nothing was applied since the last time, its state is asked for.
        """
        del at_ns
        self._take_answers()
        if not self._has_asked:
            self._send(ASK, (0.0,) * self._axes)
        self._has_asked = False
        return self._newest

    def apply(self, u: Vector, at_ns: int) -> None:
        """Send an input; the servo answers it with its state."""
        del at_ns
        self._send(MOVE, u)
        self._has_asked = True

    def close(self) -> None:
        """Ask the servo to stop; it stops by itself if that is lost."""
        if self._socket is not None:
            if self._newest is not None:
                self._send(STOP, (0.0,) * self._axes)
            self._socket.close()
            self._socket = None

    def _send(self, kind: int, u: Vector) -> None:
        self._number += 1
        try:
            self._bound.send(self._frames.command(ServoCommand(self._number, kind, u)))
        except OSError:  # a full queue, or an earlier datagram that nobody took: the next one is a period away
            self.unsent += 1

    def _take_answers(self) -> None:
        for _ in range(MOST_AT_ONCE):
            try:
                datagram = self._bound.recv(LONGEST_DATAGRAM)
            except BlockingIOError:
                return
            except OSError:  # nobody listens there at present
                continue
            self._take(datagram, self._clock())

    def _take(self, datagram: bytes, arrival_ns: int) -> None:
        answer = self._frames.answer_of(datagram)
        if answer is None or not 0 < answer.number <= self._number or not self._is_believable(answer):
            self.refused += 1
        elif answer.number <= self._answered or answer.servo_ns <= self._newest_ns:
            self.repeated += 1
        else:
            self._answered, self._newest_ns = answer.number, answer.servo_ns
            self._newest = Reading(answer.x, self._times.time_of(answer.servo_ns, arrival_ns))

    def _is_believable(self, answer: ServoAnswer) -> bool:
        return all(abs(value) <= most for value, most in zip(answer.x, self._largest, strict=True))

    @property
    def _bound(self) -> socket.socket:
        if self._socket is None:
            raise DriverError(NAME, "a servo that is not open", "open() first")
        return self._socket
