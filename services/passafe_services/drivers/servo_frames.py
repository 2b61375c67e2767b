"""Datagrams of a small servo: what is sent to it, what it answers, and how wrong ones are recognised.

All numbers are little-endian. A command is ``PSC1``, number (uint32), kind (uint32: 0 asks for the state alone, 1
moves, 2 stops), u (m float64), CRC-32 of all before. An answer is ``PSA1``, number of the command that it answers
(uint32), the servo's clock when it measured (uint64, ns), positions and rates (2m float64), CRC-32.
"""

from math import isfinite
from struct import Struct
from typing import Final, NamedTuple
from zlib import crc32

from passafe_protocol.messages import Vector

COMMAND: Final = b"PSC1"
ANSWER: Final = b"PSA1"
ASK, MOVE, STOP = 0, 1, 2

_CRC: Final = Struct("<I")


class ServoCommand(NamedTuple):
    """A command.

    Attributes:
        number: Counts up, from 1.
        kind: ``ASK``, ``MOVE`` or ``STOP``.
        u: Input, m numbers.
    """

    number: int
    kind: int
    u: Vector


class ServoAnswer(NamedTuple):
    """An answer.

    Attributes:
        number: That of the command.
        servo_ns: The servo's clock when it measured, ns.
        x: Positions, then rates; 2m numbers.
    """

    number: int
    servo_ns: int
    x: Vector


class ServoFrames:
    """Encodes and decodes the datagrams of a servo with a number of axes."""

    def __init__(self, axes: int) -> None:
        """Lay out the datagrams.

        Args:
            axes: m.
        """
        self._command, self._answer = Struct(f"<4sII{axes}d"), Struct(f"<4sIQ{2 * axes}d")

    def command(self, command: ServoCommand) -> bytes:
        """Return the datagram of a command."""
        return _sealed(self._command.pack(COMMAND, command.number, command.kind, *command.u))

    def answer(self, answer: ServoAnswer) -> bytes:
        """Return the datagram of an answer."""
        return _sealed(self._answer.pack(ANSWER, answer.number, answer.servo_ns, *answer.x))

    def command_of(self, datagram: bytes) -> ServoCommand | None:
        """Return the command of a datagram; ``None`` for anything else."""
        body = _opened(datagram, self._command.size)
        if body is None:
            return None
        mark, number, kind, *u = self._command.unpack(body)
        is_command = mark == COMMAND and kind in {ASK, MOVE, STOP} and all(map(isfinite, u))
        return ServoCommand(number, kind, tuple(u)) if is_command else None

    def answer_of(self, datagram: bytes) -> ServoAnswer | None:
        """Return the answer of a datagram; ``None`` for anything else, a number that is none included."""
        body = _opened(datagram, self._answer.size)
        if body is None:
            return None
        mark, number, servo_ns, *x = self._answer.unpack(body)
        return ServoAnswer(number, servo_ns, tuple(x)) if mark == ANSWER and all(map(isfinite, x)) else None


def _sealed(body: bytes) -> bytes:
    return body + _CRC.pack(crc32(body))


def _opened(datagram: bytes, size: int) -> bytes | None:
    """Return what a datagram of the right length holds before its checksum; ``None`` where that does not fit."""
    body, seal = datagram[:size], datagram[size:]
    return body if len(datagram) == size + _CRC.size and seal == _CRC.pack(crc32(body)) else None
