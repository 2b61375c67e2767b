"""Scores of a run in which a simulated person steered."""

from collections.abc import Iterable
from dataclasses import dataclass
from operator import itemgetter
from typing import Self

import numpy as np
from passafe_protocol.messages import FilterTick, Vector

from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.steering import Steering
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory


def steering_of(log: RunLog, trajectory: Trajectory, evaluator: PlantEvaluator) -> Steering | None:
    """Return the scores; ``None`` where no simulated person steered, or not yet.

    Of a plant that started again its last session is scored.

    Args:
        log: The log.
        trajectory: Its motion.
        evaluator: Functions of its scenario.
    """
    requests = Requests.of(
        (tick.body.effective_plant_ns, tick.body.u_h, tick.body.u_nominal, tick.body.u) for tick in log.of(FilterTick)
    )
    return steering_from(log.identity.scenario, trajectory, evaluator, requests)


@dataclass(frozen=True, kw_only=True)
class Requests:
    """What was asked of the filter and what it withheld, over plant time.

    Attributes:
        at_s: Plant times, s, increasing, shape (K,).
        asked: u_h from each of them until the next, shape (m, K).
        withheld: û − u, likewise.
    """

    at_s: FloatArray
    asked: FloatArray
    withheld: FloatArray

    @classmethod
    def of(cls, ticks: Iterable[tuple[int, Vector, Vector, Vector]]) -> Self | None:
        """Take it from plant time, ns, u_h, û and u of every tick; ``None`` without any."""
        known = sorted((tick for tick in ticks if tick[0] >= 0), key=itemgetter(0))
        if not known:
            return None
        at_ns, asked, nominal, sent = zip(*known, strict=True)
        columns = [np.array(vectors).reshape(len(known), -1).T for vectors in (asked, nominal, sent)]
        return cls(
            at_s=np.array([time_ns / NS_PER_S for time_ns in at_ns]),
            asked=columns[0],
            withheld=columns[1] - columns[2],
        )


def steering_from(
    scenario: Scenario, trajectory: Trajectory, evaluator: PlantEvaluator, requests: Requests | None
) -> Steering | None:
    """Return the scores of a run, logged or not; ``None`` where no simulated person steered, or not yet.

    Args:
        scenario: What was run.
        trajectory: Motion of the plant.
        evaluator: Functions of the scenario.
        requests: What the filter was asked for, as far as that is known.
    """
    person = scenario.operator.source
    if not isinstance(person, HumanSource) or not trajectory.samples:
        return None
    last = trajectory.session == trajectory.session[-1]
    t_s, x = trajectory.t_s[last], trajectory.x[:, last]
    with np.errstate(over="ignore", invalid="ignore"):  # a run that diverged has scores like it
        return Steering.of(
            person.targets,
            person.tolerance_m,
            t_s,
            x[: len(person.targets[0].position)],
            h=evaluator.h(x, t_s),
            asked=None if requests is None else (requests.at_s, requests.asked),
            withheld=None if requests is None else (requests.at_s, requests.withheld),
        )
