"""Messages between the server and the process of a job: one order in, lines about its progress out."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from passafe_dashboard.jobs.job_request import AnyJobRequest


class JobOrder(BaseModel):
    """The first line of a job's standard input; while it stays open, the job goes on.

    Attributes:
        request: The work.
        root: The runs folder.
        result: File to write the result to, as JSON.
        processors: Processes that may decode a long log beside one another; 0: none but the job's own.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    request: AnyJobRequest
    root: Path
    result: Path
    processors: Annotated[int, Field(ge=0)]


class JobReport(BaseModel):
    """A line of a job's standard output.

    Attributes:
        event: ``progress``; ``done``: the result is written; ``refused``: it cannot be done, for a reason in ``text``.
        share: Share of the work that is done.
        text: What it does now, or why it cannot.
        log: Log that it has written, by its name in the runs folder.
        verdict: Verdict of the review that it was, in a few words.
        experiment: Experiment that it runs, by the name of its folder.
        unfinished: Folder to remove should the job not end by itself.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    event: Literal["progress", "done", "refused"]
    share: Annotated[float, Field(ge=0, le=1)] = 0.0
    text: str = ""
    log: str = ""
    verdict: str = ""
    experiment: str = ""
    unfinished: Path | None = None
