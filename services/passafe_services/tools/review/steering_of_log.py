"""Steering metrics of a run in which a simulated person steered."""

from collections.abc import Iterable
from dataclasses import dataclass
from operator import itemgetter
from typing import Self

import numpy as np
from passafe_protocol.messages import Vector

from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.steering import Steering
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory


@dataclass(frozen=True, kw_only=True)
class Requests:
    """Request of the operator and the part that the filter held back, over plant time.

    Attributes:
        at_s: Plant times, s, increasing, shape (K,).
        requested: u_h from each time until the next, shape (m, K).
        held_back: û − u from each time until the next, shape (m, K).
    """

    at_s: FloatArray
    requested: FloatArray
    held_back: FloatArray

    @classmethod
    def of(cls, ticks: Iterable[tuple[int, Vector, Vector, Vector]]) -> Self | None:
        """Extract them from (plant time in ns, u_h, û, u) of every tick; ``None`` without ticks."""
        known = sorted((tick for tick in ticks if tick[0] >= 0), key=itemgetter(0))
        if not known:
            return None
        at_ns, requested, nominal, sent = zip(*known, strict=True)
        columns = [np.array(vectors).reshape(len(known), -1).T for vectors in (requested, nominal, sent)]
        return cls(
            at_s=np.array([time_ns / NS_PER_S for time_ns in at_ns]),
            requested=columns[0],
            held_back=columns[1] - columns[2],
        )


def steering_from(
    scenario: Scenario, trajectory: Trajectory, evaluator: PlantEvaluator, requests: Requests | None
) -> Steering | None:
    """Return the metrics of a run, logged or not; ``None`` without a simulated person, or before its first target.

    Args:
        scenario: The scenario.
        trajectory: Motion of the plant.
        evaluator: Functions of the scenario.
        requests: Requests and what was held back, if known.
    """
    person = scenario.operator.source
    if not isinstance(person, HumanSource) or not trajectory.samples:
        return None
    last = trajectory.session == trajectory.session[-1]
    t_s, x = trajectory.t_s[last], trajectory.x[:, last]
    with np.errstate(over="ignore", invalid="ignore"):  # the metrics of a diverged run may overflow
        return Steering.of(
            person.targets,
            person.tolerance_m,
            t_s,
            x[: len(person.targets[0].position)],
            h=evaluator.h(x, t_s),
            requested=None if requests is None else (requests.at_s, requests.requested),
            held_back=None if requests is None else (requests.at_s, requests.held_back),
        )
