"""Requests to end a run: signals, and an interruption from within."""

import asyncio
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from passafe_services.loop.process_exit import ExitCause, RunEnd

_SIGNALS: Final = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class EndRequests:
    """Requests to end the run of one supervisor.

    Attributes:
        stop: Set by the first signal: processes end in their own time.
        kill: Set by the second: what still runs is killed.
        interrupt: Set while the run is to be left without a signal.
    """

    def __init__(self) -> None:
        self.stop = asyncio.Event()
        self.kill = asyncio.Event()
        self.interrupt = asyncio.Event()
        self._signal = ""

    @property
    def end(self) -> RunEnd | None:
        """End of the run that was requested, or none."""
        if self.stop.is_set():
            return RunEnd(cause=ExitCause.SIGNAL, culprit=None, detail=f"stopped by {self._signal}")
        if self.interrupt.is_set():
            return RunEnd(cause=ExitCause.REQUESTED, culprit=None, detail="ended on request")
        return None

    @contextmanager
    def signals(self, loop: asyncio.AbstractEventLoop) -> Iterator[None]:
        """Handle the signals that request the end."""
        for signum in _SIGNALS:
            loop.add_signal_handler(signum, self._on_signal, signum)
        try:
            yield
        finally:
            for signum in _SIGNALS:
                loop.remove_signal_handler(signum)

    def _on_signal(self, signum: signal.Signals) -> None:
        if not self.stop.is_set():
            self._signal = signum.name
            self.stop.set()
        else:
            self.kill.set()
