"""Scores of a logged run in which a simulated person steered."""

import numpy as np

from protocol.messages import FilterTick
from services.review.log import RunLog
from services.review.mathematics import PlantMathematics
from services.review.steering import Steering
from services.review.trajectory import NS_PER_S, Trajectory
from services.scenarios.source_schema import HumanSource


def steering_of(log: RunLog, trajectory: Trajectory, mathematics: PlantMathematics) -> Steering | None:
    """Return the scores; ``None`` where no simulated person steered, or not yet.

    Of a plant that started again its last session is scored.

    Args:
        log: The log.
        trajectory: Its motion.
        mathematics: Functions of its scenario.
    """
    person = log.identity.scenario.operator.source
    if not isinstance(person, HumanSource) or not trajectory.samples:
        return None
    last = trajectory.session == trajectory.session[-1]
    t_s, x = trajectory.t_s[last], trajectory.x[:, last]
    ticks = sorted(
        (tick.body for tick in log.of(FilterTick) if tick.body.effective_plant_ns >= 0),
        key=lambda tick: tick.effective_plant_ns,
    )
    at_s = np.array([tick.effective_plant_ns / NS_PER_S for tick in ticks])
    asked = np.array([tick.u_h for tick in ticks]).reshape(len(ticks), -1).T
    withheld = np.array([np.subtract(tick.u_nominal, tick.u) for tick in ticks]).reshape(len(ticks), -1).T
    with np.errstate(over="ignore", invalid="ignore"):  # a run that diverged has scores like it
        return Steering.of(
            person.targets,
            person.tolerance_m,
            t_s,
            x[: len(person.targets[0].position)],
            h=mathematics.h(x, t_s),
            asked=(at_s, asked) if ticks else None,
            withheld=(at_s, withheld) if ticks else None,
        )
