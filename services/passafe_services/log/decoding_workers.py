"""Processes that decode stretches of a log, in turn; each has a pipe of its own and one stretch at a time.

One at a time, so that neither end of a pipe ever waits for the other to read; a process that was killed is the end of
its pipe (``docs/decisions/0017-one-pipe-per-worker.md``).
"""

import signal
from collections.abc import Mapping
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Self

from passafe.errors import PassafeError
from passafe_services.log.chunk_decoding import Decode, DecodedStretch, Stretch


class DecodingWorkerLostError(PassafeError):
    """A process that decoded part of a log was killed."""

    def __init__(self) -> None:
        super().__init__("a process that decoded part of the log was killed: out of memory?")


class DecodingWorkers:
    """Processes that decode; a context manager, which ends them.

    Args:
        count: How many, at least one.
        decode: Decodes a stretch; is sent to each of them.

    Attributes:
        count: How many there are.
    """

    def __init__(self, count: int, decode: Decode) -> None:
        self.count = count
        self._next_sent = self._next_received = 0
        context = get_context("spawn")
        self._pipes: list[Connection] = []
        self._processes = []
        for _ in range(count):
            ours, theirs = context.Pipe()
            process = context.Process(target=_serve, args=(theirs, decode), daemon=True, name="decoding")
            process.start()
            theirs.close()
            self._pipes.append(ours)
            self._processes.append(process)

    def send(self, stretch: Stretch, channels: Mapping[int, str]) -> None:
        """Send a stretch to the next process in turn, whose last result has been received."""
        try:
            self._pipes[self._next_sent % self.count].send((stretch, dict(channels)))
        except OSError as error:
            raise DecodingWorkerLostError from error
        self._next_sent += 1

    def receive(self) -> DecodedStretch:
        """Return the next result, in the order in which stretches were sent."""
        try:
            found: DecodedStretch = self._pipes[self._next_received % self.count].recv()
        except (EOFError, OSError) as error:
            raise DecodingWorkerLostError from error
        self._next_received += 1
        return found

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _type: type[BaseException] | None, _value: BaseException | None, _traceback: TracebackType | None
    ) -> None:
        for pipe in self._pipes:
            pipe.close()
        for process in self._processes:
            process.terminate()
        for process in self._processes:
            process.join()


def _serve(pipe: Connection, decode: Decode) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C goes to the parent, which ends this process
    while True:
        try:
            stretch, channels = pipe.recv()
        except EOFError:
            return
        pipe.send(decode(stretch, channels))
