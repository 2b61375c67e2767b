"""The board of jobs by itself: what its end does to jobs and to those who wait for one."""

import asyncio
from pathlib import Path

import pytest
from passafe_dashboard.archive.runs_folder import RunsFolder
from passafe_dashboard.errors import JobNameError, TooManyJobsError
from passafe_dashboard.jobs.job_board import JobBoard
from passafe_dashboard.jobs.job_order import JobReport
from passafe_dashboard.jobs.job_request import ReviewRequest

REQUEST = ReviewRequest(kind="review", log="a.mcap")


def test_the_end_answers_whoever_waits_for_a_job(tmp_path: Path) -> None:
    async def end_while_one_waits() -> str:
        board = JobBoard(RunsFolder(tmp_path), beside_robot=True)
        job = board.start(REQUEST, None)
        waiting = asyncio.create_task(job.change_after(1000, 60.0))
        await asyncio.sleep(0)
        await board.close()
        await waiting
        with pytest.raises(TooManyJobsError):
            board.start(REQUEST, None)
        return job.state

    assert asyncio.run(end_while_one_waits()) == "cancelled"


def test_the_same_work_is_asked_for_once(tmp_path: Path) -> None:
    async def ask() -> list[bool]:
        board = JobBoard(RunsFolder(tmp_path), beside_robot=False)
        first = board.start(REQUEST, 1)
        same = [board.start(REQUEST, stamp) is first for stamp in (1, 2, None)]
        await board.close()
        return same

    assert asyncio.run(ask()) == [True, False, False]


def test_progress_only_grows(tmp_path: Path) -> None:
    async def note() -> list[float]:
        board = JobBoard(RunsFolder(tmp_path), beside_robot=False)
        job = board.start(REQUEST, None)
        shares = []
        for share in (0.2, 0.1, 0.7):
            job.note(JobReport(event="progress", share=share, text="reading"))
            shares.append(job.share)
        job.note(JobReport(event="refused", text="no log"))
        assert (job.state, job.text, job.changes) == ("failed", "no log", 4)
        await board.close()
        with pytest.raises(JobNameError):
            board.job("nobody")
        return shares

    assert asyncio.run(note()) == [0.2, 0.2, 0.7]
