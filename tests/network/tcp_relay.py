"""A bad network as a program of its own: relays TCP connections with delay, jitter, a rate limit and loss.

It shares no code with the links that passafe injects, so that the two can be compared. A stream cannot lose or reorder
bytes: as under TCP, a lost segment arrives one retransmission later, and all that follows it waits.

    python tcp_relay.py --listen 10.0.0.1:7448 --to 10.0.0.1:7447 --delay 0.1 --jitter 0.02 --loss 0.01 --rate 1e6
"""

import asyncio
import random
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from contextlib import suppress
from typing import Final

CHUNK_BYTES: Final = 16_384
BUFFERED_CHUNKS: Final = 4_096
RETRANSMISSION_S: Final = 0.2
"""Least time after which TCP sends a lost segment again, where no later one reveals the loss."""


class Direction:
    """Delays the chunks of one direction of a connection."""

    def __init__(self, settings: Namespace, draw: random.Random, now: Callable[[], float]) -> None:
        self._settings = settings
        self._draw = draw
        self._now = now
        self._sent_s = 0.0
        self._arrived_s = 0.0

    def arrival_s(self, size: int) -> float:
        """Return when a chunk arrives that is received now: behind those before it."""
        given = self._settings
        self._sent_s = max(self._sent_s, self._now()) + size / given.rate
        lost_s = RETRANSMISSION_S if self._draw.random() < given.loss else 0.0
        way_s = given.delay + self._draw.uniform(-given.jitter, given.jitter) + lost_s
        self._arrived_s = max(self._arrived_s, self._sent_s + way_s)
        return self._arrived_s

    async def relay(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Relay until either end closes."""
        waiting: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue(BUFFERED_CHUNKS)

        async def receive() -> None:
            while data := await reader.read(CHUNK_BYTES):
                await waiting.put((self.arrival_s(len(data)), data))
            await waiting.put((self.arrival_s(0), b""))

        async def send() -> None:
            while True:
                arrival_s, data = await waiting.get()
                await asyncio.sleep(max(0.0, arrival_s - self._now()))
                if not data:
                    return
                writer.write(data)
                await writer.drain()

        with suppress(ConnectionError):
            await asyncio.gather(receive(), send())
        writer.close()


async def serve(settings: Namespace) -> None:
    """Relay every connection until the program is ended."""
    draw = random.Random(settings.seed)
    now = asyncio.get_running_loop().time

    async def connect(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            far_reader, far_writer = await asyncio.open_connection(*settings.to)
        except OSError:
            writer.close()
            return
        there, back = Direction(settings, draw, now), Direction(settings, draw, now)
        await asyncio.gather(there.relay(reader, far_writer), back.relay(far_reader, writer))

    server = await asyncio.start_server(connect, *settings.listen)
    await server.serve_forever()


def address(text: str) -> tuple[str, int]:
    """Return host and port."""
    host, _, port = text.rpartition(":")
    return host, int(port)


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--listen", type=address, required=True, metavar="HOST:PORT")
    parser.add_argument("--to", type=address, required=True, metavar="HOST:PORT")
    parser.add_argument("--delay", type=float, default=0.0, help="one way, s")
    parser.add_argument("--jitter", type=float, default=0.0, help="half the width of its uniform distribution, s")
    parser.add_argument("--loss", type=float, default=0.0, help="share of chunks that are sent again")
    parser.add_argument("--rate", type=float, default=float("inf"), help="bytes a second")
    parser.add_argument("--seed", type=int, default=1)
    asyncio.run(serve(parser.parse_args()))
