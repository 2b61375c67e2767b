"""Verdicts on short runs of the damped point."""

from pathlib import Path

from damped_point_run import DampedPoint, Run, rollout
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

REST = (0.0, 0.0)


def judged(run: Run, tmp_path: Path) -> Verdict:
    return Verdict.of(RunLog.read(run.write(tmp_path / "run.mcap")), DampedPoint(), derives=False)


def coasting(run: Run, *, steps: int = 200, away: float = 1.0) -> Run:
    """From (2, 0) at speed 1 away from the disk or towards it, without input."""
    rollout(run, x0=(2.0, 0.0, away, 0.0), u=lambda _: REST, steps=steps)
    return run
