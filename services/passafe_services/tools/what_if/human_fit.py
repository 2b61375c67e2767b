"""Fits the simulated person to the commands in a log: gain, reaction time and lag of the arm."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from passafe_protocol.messages import OperatorCommand, PlantState
from pydantic import BaseModel, ConfigDict

from passafe_services.operator.human.human import SimulatedHuman
from passafe_services.operator.human.steered_robot import SteeredRobot
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.tools.review.plant_evaluator import FloatArray
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S
from passafe_services.tools.what_if.errors import ChangeError

LEAST_EXPLAINED: Final = 0.6
"""Share of the commands' energy that the fitted person must explain; with less, nobody steered like this."""

LOW: Final = np.array((0.1, 0.02, 0.01))
HIGH: Final = np.array((10.0, 2.0, 1.0))
"""Ranges of the parameters, those of the schema."""

STARTS: Final = tuple((gain, reaction, 0.1) for gain in (0.7, 2.0, 5.0) for reaction in (0.1, 0.3, 0.8))
"""Parameters from the best of which the search begins: crossover, reaction, lag."""

MOST_EVALUATIONS: Final = 150
LEAST_COMMANDS: Final = 50


class HumanFit(BaseModel):
    """Simulated person fitted to a log.

    Attributes:
        crossover_rad_per_s: Gain of person and robot together, rad/s.
        reaction_s: Delay from eye to muscle, s.
        neuromuscular_s: Lag of the arm, s.
        explained: Share of the commands' energy that the model without remnant explains: 1 − ∑‖u_h − û_h‖² / ∑‖u_h‖².
        rms_error: Root mean square of what it does not explain, units of u.
        commands: Commands that it was fitted to.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    crossover_rad_per_s: float
    reaction_s: float
    neuromuscular_s: float
    explained: float
    rms_error: float
    commands: int

    @property
    def text(self) -> str:
        """The fit in words."""
        return (
            f"simulated person fitted to {self.commands} commands: crossover {self.crossover_rad_per_s:.3g} rad/s, "
            f"reaction {self.reaction_s:.3g} s, lag {self.neuromuscular_s:.3g} s; "
            f"explains {100 * self.explained:.3g} %, rms error {self.rms_error:.3g}"
        )


@dataclass(frozen=True, kw_only=True)
class _Observed:
    """Commands of one session, with what its operator saw.

    Attributes:
        at_s: Time of each command, s, from the first one on.
        u_h: Its value, shape (N, m).
        seen: State that the operator saw first when it made it; ``None``: none or no newer one.
    """

    at_s: Sequence[float]
    u_h: FloatArray
    seen: Sequence[PlantState | None]


def fit_human(log: RunLog, scenario: Scenario) -> HumanFit:
    """Fit the simulated person of a scenario to the commands in a log.

    Args:
        log: The log.
        scenario: Scenario with the person's targets; may differ from the log's.

    Raises:
        ChangeError: There is nobody to fit, or the commands are not those of a person who steers to these targets.
        SourceConfigError: A person cannot steer this robot.
    """
    source = scenario.operator.source
    if not isinstance(source, HumanSource):
        got = f"human for a log whose operator is of kind {source.kind}"
        allowed = "operator.source of kind human with its targets: give them with --set operator.source=…"
        raise ChangeError("--operator", got, allowed)
    observed = _observed(log)
    energy = float((observed.u_h**2).sum())
    if len(observed.at_s) < LEAST_COMMANDS or energy == 0.0:
        got = f"human for a log with {len(observed.at_s)} commands" + ("" if energy else ", all zero")
        raise ChangeError("--operator", got, f"{LEAST_COMMANDS} commands or more of a person who steers")
    robot = SteeredRobot.of(scenario)

    def error(parameters: FloatArray) -> float:
        return float(((_commands(source, robot, parameters, observed) - observed.u_h) ** 2).sum()) / energy

    best = min((np.array(start) for start in STARTS), key=error)
    bounds = list(zip(LOW, HIGH, strict=True))
    options = {"maxfev": MOST_EVALUATIONS, "xatol": 1e-4, "fatol": 1e-9}
    from scipy.optimize import minimize  # noqa: PLC0415 - a fifth of a second that other commands need not wait

    found = minimize(error, best, method="Nelder-Mead", bounds=bounds, options=options)
    fit = HumanFit(
        crossover_rad_per_s=float(found.x[0]),
        reaction_s=float(found.x[1]),
        neuromuscular_s=float(found.x[2]),
        explained=1.0 - float(found.fun),
        rms_error=float(np.sqrt(found.fun * energy / len(observed.at_s))),
        commands=len(observed.at_s),
    )
    if fit.explained < LEAST_EXPLAINED:
        got = f"human, who explains {100 * fit.explained:.3g} % of the commands at best"
        allowed = f"a log of somebody who steers to the targets: {100 * LEAST_EXPLAINED:g} % or more"
        raise ChangeError("--operator", got, allowed)
    return fit


def fitted(source: HumanSource, fit: HumanFit) -> HumanSource:
    """Return a person with the parameters of a fit."""
    return source.model_copy(
        update={
            "crossover_rad_per_s": fit.crossover_rad_per_s,
            "reaction_s": fit.reaction_s,
            "neuromuscular_s": fit.neuromuscular_s,
        }
    )


def _commands(source: HumanSource, robot: SteeredRobot, parameters: FloatArray, observed: _Observed) -> FloatArray:
    """Return what a person without remnant would have commanded, had it seen the same, shape (N, m)."""
    crossover, reaction, lag = np.clip(parameters, LOW, HIGH).tolist()
    update = {"crossover_rad_per_s": crossover, "reaction_s": reaction, "neuromuscular_s": lag, "remnant": 0.0}
    human = SimulatedHuman(source.model_copy(update=update), robot)
    made = []
    for at_s, state in zip(observed.at_s, observed.seen, strict=True):
        if state is not None:
            human.observe(state)
        made.append(human.command(at_s).u_h)
    return np.array(made)


def _observed(log: RunLog) -> _Observed:
    """Return the commands of the first session: each echoes the newest state that its operator had seen."""
    states = {(state.header.epoch, state.header.scheduled_ns): state.body for state in log.of(PlantState)}
    commands = log.of(OperatorCommand)
    own = [each for each in commands if each.header.epoch == commands[0].header.epoch]
    first_ns = own[0].header.scheduled_ns if own else 0
    return _Observed(
        at_s=[(each.header.scheduled_ns - first_ns) / NS_PER_S for each in own],
        u_h=np.array([each.body.u_h for each in own]).reshape(len(own), -1),
        seen=list(_newly_seen([each.body for each in own], states)),
    )


def _newly_seen(
    commands: Sequence[OperatorCommand], states: dict[tuple[int, int], PlantState]
) -> Iterator[PlantState | None]:
    known = (0, 0)
    for command in commands:
        echoed = (command.echoed_epoch, command.echoed_ns)
        yield states.get(echoed) if echoed != known else None
        known = echoed
