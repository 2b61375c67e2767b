"""Serve jobs: start one with ``POST /api/jobs``, follow it with ``GET /api/jobs/{id}``, end it with ``DELETE``."""

from http import HTTPStatus
from typing import Annotated, Final

from fastapi import APIRouter, HTTPException, Query, Response
from fastapi.responses import FileResponse
from pydantic import BaseModel, ConfigDict

from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.jobs.job_board import JobState, PageJob
from passafe_dashboard.jobs.job_request import AnyJobRequest
from passafe_dashboard.routes.answers import UNKNOWN_NAME, refused

ACCEPTED: Final = 202
LONGEST_WAIT_S: Final = 10.0


class JobView(BaseModel):
    """A job as the page sees it.

    Attributes:
        job: Its id.
        request: The work.
        state: waiting, running, done, failed or cancelled.
        share: Share of the work that is done.
        text: What it does now, or why it failed.
        result: Address of its result; ``None`` before it is done.
        log: Log that it has written, by its name; empty for none.
        experiment: Experiment that it runs, by the name of its folder; empty for none, and before it has one.
        changes: How often it has changed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    job: str
    request: AnyJobRequest
    state: JobState
    share: float
    text: str
    result: str | None
    log: str
    experiment: str
    changes: int

    @classmethod
    def of(cls, job: PageJob) -> "JobView":
        """Return the view of a job."""
        result = f"/api/jobs/{job.id}/result" if job.state == "done" else None
        return cls(
            job=job.id,
            request=job.request,
            state=job.state,
            share=job.share,
            text=job.text,
            result=result,
            log=job.log,
            experiment=job.experiment,
            changes=job.changes,
        )


class JobViews(BaseModel):
    """All jobs that are known, the oldest first."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    jobs: tuple[JobView, ...]


def job_routes(archive: Archive) -> APIRouter:
    """Return the routes of jobs."""
    router = APIRouter(tags=["jobs"])
    board = archive.board
    too_many = refused(HTTPStatus.TOO_MANY_REQUESTS, "Too many jobs are open")
    not_done = refused(HTTPStatus.CONFLICT, "It is not done")

    @router.post("/api/jobs", status_code=ACCEPTED, responses=UNKNOWN_NAME | too_many)
    async def start(request: AnyJobRequest) -> JobView:
        """Start a job; one that has the same work at hand or done already is returned instead."""
        return JobView.of(await archive.start(request))

    @router.get("/api/jobs")
    async def jobs() -> JobViews:
        """List the jobs, the oldest first."""
        return JobViews(jobs=tuple(JobView.of(job) for job in board.jobs.values()))

    @router.get("/api/jobs/{name}", responses=UNKNOWN_NAME)
    async def job(name: str, seen: Annotated[int, Query(ge=-1)] = -1) -> JobView:
        """Return a job; with ``seen``, its ``changes`` in an earlier answer, wait some seconds for another change."""
        found = board.job(name)
        await found.change_after(seen, LONGEST_WAIT_S)
        return JobView.of(found)

    @router.get("/api/jobs/{name}/result", responses=UNKNOWN_NAME | not_done)
    async def result(name: str) -> Response:
        """Return the result of a job that is done: title, markup and data of a report."""
        found = board.job(name)
        if found.state != "done":
            raise HTTPException(
                HTTPStatus.CONFLICT, f"job {found.id}: got the state {found.state}, allowed done: {found.text}"
            )
        return FileResponse(found.result, media_type="application/json")

    @router.delete("/api/jobs/{name}", responses=UNKNOWN_NAME)
    async def cancel(name: str) -> JobView:
        """End a job; one that is over stays as it is."""
        return JobView.of(await board.cancel(name))

    return router
