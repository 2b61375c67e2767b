"""Start, follow and end jobs: one at a time and one sweep, a bounded number that waits, results kept for a while."""

import asyncio
import os
import shutil
import signal
import sys
from asyncio.subprocess import PIPE, Process
from collections.abc import Mapping
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final, Literal

from passafe_services.loop.realtime import available_processors

from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.errors import JobNameError, OneSweepError, TooManyJobsError
from passafe_dashboard.jobs.job_order import JobOrder, JobReport
from passafe_dashboard.jobs.job_request import AnyJobRequest, ReviewRequest, SweepRequest

MOST_AT_A_TIME: Final = 1
"""Jobs other than a sweep that run: a sweep takes minutes, and reviews do not wait for it."""

MOST_OPEN: Final = 8
"""Jobs that wait or run; more are refused."""

MOST_KEPT: Final = 24
"""Jobs that are over and whose results are kept."""

NICENESS: Final = 5
"""Niceness of jobs beside a robot: a third of the share of an ordinary process."""

SWEEP_NICENESS: Final = 10
"""The same of a sweep, which takes minutes: a tenth."""

LONGEST_LINE_BYTES: Final = 1 << 20
LONGEST_ERROR_BYTES: Final = 4096

JobState = Literal["waiting", "running", "done", "failed", "cancelled"]
OPEN: Final = ("waiting", "running")

_COMMAND: Final = (sys.executable, "-P", "-m", "passafe_dashboard.jobs.job_process")


@dataclass(kw_only=True, eq=False)
class PageJob:
    """A job and what is known of it.

    Attributes:
        id: Its name.
        request: The work.
        stamp: State of the files that it is about when it was asked for.
        result: File of its result.
        state: Where it is.
        share: Share of the work that is done.
        text: What it does now, or why it failed.
        log: Log that it has written, by its name; empty for none.
        verdict: Verdict of the review that it was, in a few words; empty before it is done, and for other work.
        experiment: Experiment that it runs, by the name of its folder; empty for none, and before it has one.
        unfinished: Folder to remove if its process does not end by itself.
        changes: How often any of these has changed.
        task: Follows its process.
        changed: Set at the next change.
    """

    id: str
    request: AnyJobRequest
    stamp: object
    result: Path
    state: JobState = "waiting"
    share: float = 0.0
    text: str = "waiting for its turn"
    log: str = ""
    verdict: str = ""
    experiment: str = ""
    unfinished: Path | None = None
    changes: int = 0
    task: asyncio.Task[None] | None = field(default=None, repr=False)
    changed: asyncio.Event = field(default_factory=asyncio.Event, repr=False)

    def become(self, state: JobState, text: str) -> None:
        """Note a state and what is to be said of it, and wake whoever waits for a change."""
        self.state, self.text = state, text
        self.changes += 1
        self.changed.set()
        self.changed = asyncio.Event()

    def note(self, report: JobReport) -> None:
        """Take a line of its process."""
        self.unfinished = report.unfinished or self.unfinished
        self.share = max(self.share, report.share)
        self.log, self.verdict = report.log or self.log, report.verdict
        self.experiment = report.experiment or self.experiment
        states: dict[str, JobState] = {"done": "done", "refused": "failed"}
        self.become(states.get(report.event, "running"), report.text or self.text)

    async def change_after(self, seen: int, timeout_s: float) -> None:
        """Wait until it has changed more often than ``seen`` times, or is over; no longer than ``timeout_s``."""
        if self.changes <= seen and self.state in OPEN:
            with suppress(TimeoutError):
                await asyncio.wait_for(self.changed.wait(), timeout_s)


class JobBoard:
    """Jobs of one server.

    Args:
        folder: The runs folder.
        beside_robot: Whether a robot is driven on this machine: then a job has one process, which gives way.
    """

    def __init__(self, folder: RunsFolder, *, beside_robot: bool) -> None:
        self._folder = folder
        self._processors = 0 if beside_robot else available_processors()
        self._beside_robot = beside_robot
        self._jobs: dict[str, PageJob] = {}
        self._numbers = count(1)
        self._turn = asyncio.Semaphore(MOST_AT_A_TIME)
        self._results: TemporaryDirectory[str] | None = None
        self._is_closed = False

    @property
    def jobs(self) -> Mapping[str, PageJob]:
        """All jobs that are known, by id, the oldest first."""
        return self._jobs

    def job(self, name: str) -> PageJob:
        """Return a job.

        Raises:
            JobNameError: There is none of that name, or no more.
        """
        if name not in self._jobs:
            raise JobNameError(name[:80])
        return self._jobs[name]

    def start(self, request: AnyJobRequest, stamp: object) -> PageJob:
        """Return the job for a request: a new one, or one that has the same work done already or at hand.

        Args:
            request: The work.
            stamp: State of the files that it is about; with another the work is done again. ``None``: always anew.

        Raises:
            TooManyJobsError: Too many are open, or the server is ending.
            OneSweepError: It is a sweep, and another one is open.
        """
        if stamp is not None:
            for job in self._jobs.values():
                if job.request == request and job.stamp == stamp and job.state in (*OPEN, "done"):
                    return job
        is_open = sum(job.state in OPEN for job in self._jobs.values())
        if is_open >= MOST_OPEN or self._is_closed:
            raise TooManyJobsError(is_open)
        if isinstance(request, SweepRequest):
            self._require_no_sweep()
        name = str(next(self._numbers))
        if self._results is None:
            self._results = TemporaryDirectory(prefix="passafe-page-", ignore_cleanup_errors=True)
        job = PageJob(id=name, request=request, stamp=stamp, result=Path(self._results.name) / f"{name}.json")
        self._jobs[name] = job
        job.task = asyncio.create_task(self._run(job))
        self._forget_old()
        return job

    def verdict(self, log: str, stamp: object) -> str:
        """Return the verdict of a log's review, in a few words; empty if it was not reviewed as it is now.

        Args:
            log: Its name.
            stamp: State of its files.
        """
        request = ReviewRequest(kind="review", log=log)
        reviews = (job for job in self._jobs.values() if (job.request, job.stamp) == (request, stamp))
        return next((job.verdict for job in reviews if job.verdict), "")

    def sweep_of(self, experiment: str) -> PageJob | None:
        """Return the newest job that ran an experiment, by the name of its folder; ``None`` if there is none."""
        return next((job for job in reversed(self._jobs.values()) if job.experiment == experiment), None)

    async def cancel(self, name: str) -> PageJob:
        """End a job if it is not over; return it.

        Raises:
            JobNameError: There is none of that name, or no more.
        """
        job = self.job(name)
        if job.state in OPEN and job.task is not None:
            job.task.cancel()
            await asyncio.wait({job.task})
        return job

    async def close(self) -> None:
        """End every job, for good, and remove the results."""
        self._is_closed = True
        tasks = [job.task for job in self._jobs.values() if job.task is not None and not job.task.done()]
        for task in tasks:
            task.cancel()
        if tasks:
            await asyncio.wait(tasks)
        if self._results is not None:
            await asyncio.to_thread(self._results.cleanup)
            self._results = None

    async def _run(self, job: PageJob) -> None:
        turn = nullcontext() if isinstance(job.request, SweepRequest) else self._turn
        try:
            async with turn:
                job.become("running", "starting")
                await self._follow(job)
        except asyncio.CancelledError:
            job.become("cancelled", "cancelled")
        except OSError as error:
            job.become("failed", f"its process cannot be started: {error.strerror or error}")

    async def _follow(self, job: PageJob) -> None:
        order = JobOrder(request=job.request, root=self._folder.root, result=job.result, processors=self._processors)
        process = await asyncio.create_subprocess_exec(
            *_COMMAND,
            str(self._niceness(job.request)),
            stdin=PIPE,
            stdout=PIPE,
            stderr=PIPE,
            start_new_session=True,
            limit=LONGEST_LINE_BYTES,
        )
        try:
            errors = asyncio.create_task(_last_bytes(process))
            await _send(process, order)
            await _receive(process, job)
            await process.wait()
            last_words = await errors
        finally:
            _kill(process)
            await process.wait()
            if job.unfinished is not None:
                await asyncio.to_thread(shutil.rmtree, job.unfinished, ignore_errors=True)
        if job.state == "running":
            code = process.returncode or 0
            reason = f"signal {-code}" if code < 0 else f"code {code}"
            job.become("failed", f"its process ended with {reason}: {last_words or 'out of memory?'}")

    def _niceness(self, request: AnyJobRequest) -> int:
        if not self._beside_robot:
            return 0
        return SWEEP_NICENESS if isinstance(request, SweepRequest) else NICENESS

    def _require_no_sweep(self) -> None:
        for job in self._jobs.values():
            if isinstance(job.request, SweepRequest) and job.state in OPEN:
                raise OneSweepError(job.experiment or job.request.experiment)

    def _forget_old(self) -> None:
        over = [job for job in self._jobs.values() if job.state not in OPEN]
        for job in over[: max(0, len(over) - MOST_KEPT)]:
            del self._jobs[job.id]
            job.result.unlink(missing_ok=True)


async def _send(process: Process, order: JobOrder) -> None:
    if process.stdin is not None:
        with suppress(ConnectionError):  # it has died, which its exit tells
            process.stdin.write(order.model_dump_json().encode() + b"\n")
            await process.stdin.drain()


async def _receive(process: Process, job: PageJob) -> None:
    """Take the lines of a job's process until its end."""
    if process.stdout is not None:
        async for line in process.stdout:
            with suppress(ValueError):  # a line of something else, such as a warning of a library
                job.note(JobReport.model_validate_json(line))


async def _last_bytes(process: Process) -> str:
    """Return the last line that a process wrote on standard error."""
    kept = b""
    while process.stderr is not None and (part := await process.stderr.read(LONGEST_ERROR_BYTES)):
        kept = (kept + part)[-LONGEST_ERROR_BYTES:]
    lines = kept.decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else ""


def _kill(process: Process) -> None:
    """Kill a job's process and those that it started."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
