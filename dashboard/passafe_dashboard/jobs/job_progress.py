"""Report the progress of a job, now and then."""

from collections.abc import Callable
from typing import Final

from passafe_dashboard.jobs.job_order import JobReport

LEAST_STEP: Final = 0.01
"""Smallest share of the work that is worth a line."""


class JobProgress:
    """Progress of a job, in parts that follow one another.

    Args:
        report: Takes the lines.

    Attributes:
        report: The same.
    """

    def __init__(self, report: Callable[[JobReport], object]) -> None:
        self.report = report
        self._last = -1.0

    def part(self, text: str, low: float, high: float) -> Callable[[int, int], None]:
        """Return what takes steps done, and all steps, of a part of the work.

        Args:
            text: What is done in it.
            low: Share of the whole work that is done when it begins.
            high: The same when it ends.
        """

        def step(done: int, number: int) -> None:
            share = low + (high - low) * min(1.0, done / max(number, 1))
            if share - self._last >= LEAST_STEP or done == 0:
                self._last = share
                self.report(JobReport(event="progress", share=share, text=text))

        step(0, 1)
        return step
