"""The archive of a page: the runs folder, what is listed of it, and the jobs that work on it."""

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from passafe_dashboard.archive.experiment_models import (
    ExperimentEntry,
    ExperimentList,
    ExperimentOffers,
    ExperimentView,
    SweepJob,
)
from passafe_dashboard.archive.log_list import LogEntry, LogList, LogLister
from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.errors import ArchiveNameError
from passafe_dashboard.jobs.job_board import JobBoard, PageJob
from passafe_dashboard.jobs.job_request import (
    AnyJobRequest,
    CellRunRequest,
    CompareRequest,
    SweepRequest,
    WhatIfRequest,
)

if TYPE_CHECKING:
    from passafe_dashboard.archive.experiment_offers import OfferLister
    from passafe_dashboard.archive.experiments import Experiments


class Archive:
    """Logs and experiments in a folder, and work on them. Its methods belong to the server's event loop.

    Args:
        root: The runs folder.
        beside_robot: Whether a robot is driven on this machine, so that jobs have to give way.
    """

    def __init__(self, root: Path, *, beside_robot: bool) -> None:
        self.folder = RunsFolder(root)
        self.board = JobBoard(self.folder, beside_robot=beside_robot)
        self._lister = LogLister(self.folder)
        self._experiments: Experiments | None = None
        self._offers: OfferLister | None = None
        self._reading = asyncio.Lock()  # one look at the disk at a time, however many pages ask

    async def logs(self) -> LogList:
        """Return the logs, the newest first."""
        async with self._reading:
            found = await asyncio.to_thread(self._lister.newest)
        return found.model_copy(update={"logs": tuple(map(self._judged, found.logs))})

    async def log(self, name: str) -> LogEntry:
        """Return one log.

        Raises:
            ArchiveNameError: There is no such log in the folder.
        """
        async with self._reading:
            return self._judged(await asyncio.to_thread(self._lister.entry, name))

    async def experiments(self) -> ExperimentList:
        """Return the experiments, the newest first."""
        async with self._reading:
            found = await asyncio.to_thread(lambda: self._known_experiments().newest())
        return ExperimentList(experiments=tuple(map(self._with_job, found.experiments)))

    async def experiment(self, name: str) -> ExperimentView:
        """Return the map of an experiment, as far as it has come.

        Raises:
            ArchiveNameError: There is no such experiment in the folder, or its results cannot be read.
        """
        async with self._reading:
            found = await asyncio.to_thread(lambda: self._known_experiments().view(name))
        return found.model_copy(update={"entry": self._with_job(found.entry)})

    async def offers(self) -> ExperimentOffers:
        """Return the experiments that can be started."""
        async with self._reading:
            return await asyncio.to_thread(lambda: self._known_offers().all())

    async def start(self, request: AnyJobRequest) -> PageJob:
        """Return the job for a request.

        Raises:
            ArchiveNameError: It names a log or experiment that there is not.
            TooManyJobsError: Too many jobs are open, or a sweep is asked for beside another.
        """
        if isinstance(request, CellRunRequest):
            await asyncio.to_thread(self.folder.experiment, request.experiment)
            return self.board.start(request, None)
        if isinstance(request, SweepRequest):
            return await self._start_sweep(request)
        names = request.logs if isinstance(request, CompareRequest) else (request.log,)
        entries = [await self.log(name) for name in names]
        stamp = None if isinstance(request, WhatIfRequest) else [each.stamp for each in entries]
        return self.board.start(request, stamp)

    async def _start_sweep(self, request: SweepRequest) -> PageJob:
        if request.source == "shipped":
            shipped = [offer.experiment for offer in (await self.offers()).offers if offer.source == "shipped"]
            if request.experiment not in shipped:
                raise ArchiveNameError("experiment", request.experiment, f"one of {', '.join(shipped)}")
        elif request.source == "file":
            await asyncio.to_thread(self.folder.experiment_file, request.experiment)
        else:
            await asyncio.to_thread(self.folder.experiment, request.experiment)
        job = self.board.start(request, None)
        if request.source == "folder":
            job.experiment = request.experiment
        return job

    def _with_job(self, entry: ExperimentEntry) -> ExperimentEntry:
        """Return an entry with the job of this server that runs it, or ran it last."""
        job = self.board.sweep_of(entry.name)
        found = None if job is None else SweepJob(job=job.id, state=job.state, text=job.text)
        return entry.model_copy(update={"job": found})

    def _judged(self, entry: LogEntry) -> LogEntry:
        """Return an entry with the verdict of its review, if there was one."""
        return entry.model_copy(update={"verdict": self.board.verdict(entry.name, [entry.stamp])})

    def _known_experiments(self) -> "Experiments":
        if self._experiments is None:
            from passafe_dashboard.archive.experiments import Experiments  # noqa: PLC0415 - a second to load

            self._experiments = Experiments(self.folder)
        return self._experiments

    def _known_offers(self) -> "OfferLister":
        if self._offers is None:
            from passafe_dashboard.archive.experiment_offers import OfferLister  # noqa: PLC0415 - likewise

            self._offers = OfferLister(self.folder)
        return self._offers

    async def close(self) -> None:
        """End all jobs."""
        await self.board.close()
