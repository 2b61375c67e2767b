"""Reports the runs of a demo on the terminal: that they run, how they ended, the verdicts on their logs."""

import asyncio
import os
import sys
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.markup import escape

from passafe_services.cli.demo_outcome import DIED, report_end, report_outcome
from passafe_services.loop.process_exit import ExitCause, RunOutcome
from passafe_services.session.planned_run import PlannedRun
from passafe_services.session.run_session import Conclude
from passafe_services.tools.review.verdict import Verdict

REVIEW_NICENESS: Final = 10
"""Niceness of a review beside the next run."""


@dataclass(frozen=True, kw_only=True, slots=True)
class _Ended:
    """A run that has ended and is to be judged."""

    number: int
    run: PlannedRun
    outcome: RunOutcome
    tell: Callable[[str, str], None]


class DemoReports:
    """Reports of one demo; those of runs that were ended on request are made beside the next run.

    Args:
        console: Where to print.
        address: Address of the page; empty if there is none.
    """

    def __init__(self, console: Console, address: str) -> None:
        self._console = console
        self._address = address
        self._waiting: deque[_Ended] = deque()
        self._thread: threading.Thread | None = None
        self._code = 0
        self._folder: Path | None = None

    def ready(self, number: int, run: PlannedRun) -> None:
        """Print that a run is going on, and with the first one the address of the page."""
        if number > 1:
            self._console.print(f"run {number}: {_described(run)}")
            return
        if self._address:
            self._console.print(f"dashboard {self._address}")
        ends = run.scenario.duration_s if run.most_s is not None else None
        self._console.print("running; end with Ctrl-C" if ends is None else f"running for {ends:g} s")

    def ended(self, number: int, run: PlannedRun, outcome: RunOutcome, conclude: Conclude, *, began: bool) -> None:
        """Judge a run that has ended: now, beside the next one, if that was requested, and else in ``finish``."""
        if not began and (outcome.cause is ExitCause.REQUESTED or (outcome.cause is ExitCause.SIGNAL and number > 1)):
            self._console.print(f"run {number} was ended before it began: nothing to judge")
            return
        loop = asyncio.get_running_loop()

        def tell(word: str, words: str) -> None:
            with suppress(RuntimeError):  # the loop has been closed: nobody listens any more
                loop.call_soon_threadsafe(conclude, word, words)

        self._waiting.append(_Ended(number=number, run=run, outcome=outcome, tell=tell))
        if outcome.cause is ExitCause.REQUESTED and (self._thread is None or not self._thread.is_alive()):
            thread = threading.Thread(target=self._judge_politely, daemon=True)
            with suppress(RuntimeError):  # no thread can be started: it is judged in the end
                thread.start()
                self._thread = thread

    def finish(self) -> int:
        """Judge what is left; return the exit code of the worst run."""
        if self._thread is not None:
            self._thread.join()
        self._judge_all()
        if self._folder is not None:
            self._console.print(f"to see   passafe browse {escape(str(self._folder))}")
        return self._code

    def _judge_politely(self) -> None:
        if sys.platform == "linux":  # there the niceness of a thread is its own
            with suppress(OSError):
                os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), REVIEW_NICENESS)
        self._judge_all()

    def _judge_all(self) -> None:
        while self._waiting:
            self._code = max(self._code, self._judge(self._waiting[0]))
            self._waiting.popleft()

    def _judge(self, ended: _Ended) -> int:
        run, outcome = ended.run, ended.outcome
        if ended.number > 1 or outcome.cause is ExitCause.REQUESTED:
            self._console.print(f"run {ended.number}, {_described(run)}: {escape(outcome.detail)}")
        if run.log is None:
            in_order = report_end(outcome, self._console, has_end=run.most_s is not None)
            self._console.print("not recorded: no verdict")
            ended.tell("", "not recorded: no verdict")
            return 0 if in_order else DIED
        self._folder = run.log.parent
        verdicts: list[Verdict] = []
        code = report_outcome(outcome, run.log, self._console, verdicts.append)
        if verdicts:
            ended.tell(verdicts[0].verdict, verdicts[0].words)
        else:
            ended.tell("unproven", "this run has no log")
        return code


def _described(run: PlannedRun) -> str:
    law = run.scenario.filter
    log = "not recorded" if run.log is None else f"log {run.log}"
    prediction = "" if law.prediction else ", without prediction"
    return f"{run.scenario.name}, mode {law.mode}{prediction}, {run.scenario.rate_hz:g} Hz, {log}"
