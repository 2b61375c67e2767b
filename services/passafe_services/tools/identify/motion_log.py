"""Stretches of logs in which the robot moved and no state is missing."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import PlantPhase, PlantState

from passafe_services.log.continuity import LoggedMessage
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.identify.errors import IdentifyError
from passafe_services.tools.review.run_log import RunLog

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class UnbrokenMotion:
    """States that follow one another at whole periods.

    Attributes:
        x: States as read, shape (N, n).
        u: Input in force from each state until the next, shape (N, m).
    """

    x: FloatArray
    u: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class LoggedMotion:
    """LoggedMotion in several logs of one robot.

    Attributes:
        scenario: Scenario of the first log.
        stretches: Of all logs.
    """

    scenario: Scenario
    stretches: tuple[UnbrokenMotion, ...]

    @property
    def samples(self) -> int:
        """Number of states."""
        return sum(len(stretch.x) for stretch in self.stretches)


def motion_of(paths: Sequence[Path]) -> LoggedMotion:
    """Return the motion in logs.

    Args:
        paths: The logs, of one model at one rate.

    Raises:
        LogFileError: A log that cannot be read.
        IdentifyError: Logs of different robots or rates, or without motion.
    """
    logs = [RunLog.read(path) for path in paths]
    scenario = logs[0].identity.scenario
    for path, log in zip(paths, logs, strict=True):
        other = log.identity.scenario
        if _robot_of(other) != _robot_of(scenario):
            got = f"{path.name} of {other.name} at {other.rate_hz:g} Hz"
            raise IdentifyError("LOG", got, f"logs of one robot and rate, as {paths[0].name}")
    found = tuple(stretch for log in logs for stretch in _stretches(log, round(1e9 / scenario.rate_hz)))
    if not found:
        raise IdentifyError("LOG", "no states that follow one another in motion", "a log in which the robot moves")
    return LoggedMotion(scenario=scenario, stretches=found)


def _robot_of(scenario: Scenario) -> tuple[object, ...]:
    plant = scenario.plant
    return plant.model, plant.parameters, plant.robot, scenario.rate_hz


def _stretches(log: RunLog, period_ns: int) -> Iterator[UnbrokenMotion]:
    states = log.of(PlantState)
    begin = 0
    for end in range(1, len(states) + 1):
        if end < len(states) and _follow(states[end - 1], states[end], period_ns):
            continue
        run = [state.body for state in states[begin:end] if state.body.phase is not PlantPhase.WAITING]
        if len(run) > 1:
            yield UnbrokenMotion(x=np.array([state.x for state in run]), u=np.array([state.u for state in run]))
        begin = end


def _follow(before: LoggedMessage[PlantState], after: LoggedMessage[PlantState], period_ns: int) -> bool:
    """Return whether one state follows another at a period, or the plant still waits."""
    one, two = before.header, after.header
    step_ns = after.body.plant_ns - before.body.plant_ns
    is_next = one.epoch == two.epoch and two.sequence == one.sequence + 1
    return is_next and (after.body.phase is PlantPhase.WAITING or step_ns in (period_ns, 0))
