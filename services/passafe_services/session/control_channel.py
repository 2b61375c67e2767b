"""The channel between a demo's supervisor and its page: typed messages, a line of JSON each, over a socket pair."""

import asyncio
import socket
from contextlib import suppress
from typing import Final, Generic, Self, TypeVar

from pydantic import TypeAdapter, ValidationError

from passafe_services.session.control_messages import ControlMessage

LONGEST_LINE_BYTES: Final = 262_144
MOST_UNSENT_BYTES: Final = 1_048_576
"""What may wait for the other end to read; one that does not is not worth more memory."""

Received = TypeVar("Received", bound=ControlMessage)


class ControlChannel(Generic[Received]):
    """One end of the channel; use it from one event loop.

    Args:
        reader: What the other end writes.
        writer: What the other end reads.
        received: Kind of messages that the other end sends.
    """

    def __init__(
        self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, received: TypeAdapter[Received]
    ) -> None:
        self._reader = reader
        self._writer = writer
        self._received = received

    @classmethod
    async def over(cls, end: socket.socket, received: TypeAdapter[Received]) -> Self:
        """Return the channel over one socket of a connected pair, which it then owns."""
        end.setblocking(False)
        reader, writer = await asyncio.open_connection(sock=end, limit=LONGEST_LINE_BYTES)
        return cls(reader, writer, received)

    def send(self, message: ControlMessage) -> bool:
        """Send a message; return false, and send nothing, to an end that has closed or does not read."""
        transport = self._writer.transport
        if transport.is_closing() or transport.get_write_buffer_size() > MOST_UNSENT_BYTES:
            return False
        self._writer.write(message.model_dump_json().encode() + b"\n")
        return True

    async def receive(self) -> Received | None:
        """Return the next message; ``None`` once the other end has closed, or has sent what is no message."""
        with suppress(OSError, ValueError, ValidationError):  # a line too long is a ValueError
            line = await self._reader.readline()
            if line.endswith(b"\n"):
                return self._received.validate_json(line)
        return None

    def close(self) -> None:
        """Close this end."""
        self._writer.close()
