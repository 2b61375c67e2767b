"""Estimation of a robot from its logs: parameters, noise, and the smallest sets that explain the motion."""

from collections.abc import Mapping, Sequence
from math import ceil, floor, log10
from typing import Any, Final

import numpy as np
from pydantic import BaseModel, ConfigDict

from passafe_services.plant_contract.state_estimate import StateEstimate
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.suggestion import suggestion
from passafe_services.tools.identify.errors import IdentifyError
from passafe_services.tools.identify.motion_log import FloatArray, LoggedMotion
from passafe_services.tools.identify.window_fit import WindowFit, fit_windows
from passafe_services.tools.review.run_review import growth_of

WINDOW_S: Final = 0.5
LEFT_OUT: Final = 1e-3
SIGMAS: Final = 3.0
"""Standard errors on either side of an estimate that its interval takes in."""

VAGUE: Final = 0.3
"""Relative standard error above which logs say too little of a parameter."""

HALVINGS: Final = 7
DOUBLINGS: Final = 20
DIGITS: Final = 4


class Identification(BaseModel):
    """Estimate of a robot, and sets in which it is.

    Attributes:
        samples: States that were used.
        parameters: Estimates by name.
        errors: Their standard errors.
        unknown: Parameters of which the logs say too little; they keep the model's value.
        noise: Standard deviation of the noise of each state.
        intervals: Interval of each parameter.
        state_error: Bound of each state's error.
        disturbance: Bound of the disturbance of each state's rate.
        left_out: Share of the states that these sets do not explain.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    samples: int
    parameters: dict[str, float]
    errors: dict[str, float]
    unknown: tuple[str, ...]
    noise: tuple[float, ...]
    intervals: dict[str, tuple[float, float]]
    state_error: tuple[float, ...]
    disturbance: tuple[float, ...]
    left_out: float

    def scenario_lines(self) -> str:
        """Return the lines of a scenario file that state these parameters and sets."""
        values = ", ".join(f"{name} = {value:.6g}" for name, value in self.parameters.items())
        intervals = ", ".join(f"{name} = [{low:g}, {high:g}]" for name, (low, high) in self.intervals.items())
        lines = [
            "# in [plant]:",
            f"parameters = {{ {values} }}",
            "",
            "[uncertainty]",
            f"parameters = {{ {intervals} }}",
            f"disturbance = {_listed(self.disturbance)}",
            f"state_error = {_listed(self.state_error)}",
        ]
        return "\n".join(lines) + "\n"


def identify(
    motion: LoggedMotion,
    names: Sequence[str] = (),
    *,
    window_s: float = WINDOW_S,
    left_out: float = LEFT_OUT,
) -> Identification:
    """Return the estimate of the robot of some motion.

    Args:
        motion: What it did.
        names: Parameters to estimate; all of the model if empty.
        window_s: Length of the windows in which a disturbance may count as constant, s.
        left_out: Share of the states that the sets need not explain.

    Raises:
        IdentifyError: Parameters that the model does not have, or motion shorter than a window.
    """
    scenario = motion.scenario
    system = robot_of(scenario).system
    known = [parameter.name for parameter in system.parameters]
    for name in names:
        if name not in known:
            raise IdentifyError("--parameter", name, f"{', '.join(known)}{suggestion(name, known)}")
    periods = max(round(window_s * scenario.rate_hz), 2)
    longest = max(len(stretch.x) for stretch in motion.stretches)
    if longest <= periods:
        got = f"{longest} states in a row at most"
        raise IdentifyError("LOG", got, f"{periods + 1} or more, a window of {window_s:g} s; --window sets another")
    fit = fit_windows(system, motion.stretches, names or known, scenario.dt_s, periods)
    vague = [name for name, value, error in _estimates(fit) if not error <= VAGUE * abs(value)]
    if vague:
        left = [name for name in fit.names if name not in vague]
        fit = fit_windows(system, motion.stretches, left, scenario.dt_s, periods)
    parameters = {name: _rounded(value) for name, value, _ in _estimates(fit)}
    intervals = {
        name: (_down(value - SIGMAS * error), _up(value + SIGMAS * error)) for name, value, error in _estimates(fit)
    }
    state_error = tuple(_up(bound) for bound in np.quantile(np.abs(fit.residuals), 1 - left_out, axis=0).tolist())
    sets = {"parameters": intervals, "state_error": state_error}
    disturbance, share = _smallest_disturbance(motion, parameters, sets, fit, left_out)
    return Identification(
        samples=motion.samples,
        parameters=parameters,
        errors={name: error for name, _, error in _estimates(fit)},
        unknown=tuple(vague),
        noise=tuple(fit.noise.tolist()),
        intervals=intervals,
        state_error=state_error,
        disturbance=disturbance,
        left_out=share,
    )


def _estimates(fit: WindowFit) -> list[tuple[str, float, float]]:
    return list(zip(fit.names, fit.values.tolist(), fit.errors.tolist(), strict=True))


def _smallest_disturbance(
    motion: LoggedMotion, parameters: Mapping[str, float], sets: Mapping[str, Any], fit: WindowFit, left_out: float
) -> tuple[tuple[float, ...], float]:
    """Return the smallest disturbance with which the sets explain all but a share of the states, and that share."""
    pushes = np.abs(fit.pushes).max(axis=0)
    shape: FloatArray = (pushes > 0).astype(np.float64)

    def left(size: float) -> float:
        disturbance = tuple((size * shape).tolist())
        return share_outside(motion, scenario_with(motion.scenario, parameters, {**sets, "disturbance": disturbance}))

    low, high = 0.0, 0.0
    share = left(high)
    for _ in range(DOUBLINGS):
        if share <= left_out:
            break
        low, high = high, 2 * high or max(float(np.median(pushes[pushes > 0])) / 2, 1e-6)
        share = left(high)
    for _ in range(HALVINGS if high else 0):
        middle = (low + high) / 2
        found = left(middle)
        if found <= left_out:
            high, share = middle, found
        else:
            low = middle
    return tuple(_up(size) for size in (high * shape).tolist()), share


def scenario_with(scenario: Scenario, parameters: Mapping[str, float], sets: Mapping[str, Any]) -> Scenario:
    """Return a scenario with other parameters and sets, and nothing of a truth or guard."""
    data = scenario.model_dump()
    data["plant"] |= {"parameters": scenario.plant.parameters | dict(parameters), "truth": None, "guard": None}
    data["uncertainty"] = sets
    return Scenario.model_validate(data)


def share_outside(motion: LoggedMotion, scenario: Scenario) -> float:
    """Return the share of the states that lie outside of what a scenario's sets allow from those before."""
    growth = growth_of(scenario)
    if growth is None:
        raise IdentifyError("uncertainty", "none", "a scenario with sets")
    outside = compared = 0
    for stretch in motion.stretches:
        estimate, before = StateEstimate(growth), None
        for x, u in zip(map(tuple, stretch.x.tolist()), map(tuple, stretch.u.tolist()), strict=True):
            estimate.observe(x, before)
            compared += bool(estimate.residual)
            outside += estimate.is_violated
            before = (u,)
    return outside / max(compared, 1)


def _listed(numbers: Sequence[float]) -> str:
    return f"[{', '.join(f'{number:g}' for number in numbers)}]"


def _unit(value: float) -> float:
    return 10.0 ** (floor(log10(abs(value))) - DIGITS + 1)


def _up(value: float) -> float:
    return 0.0 if not value else float(f"{ceil(value / _unit(value)) * _unit(value):.{DIGITS}g}")


def _down(value: float) -> float:
    return 0.0 if not value else float(f"{floor(value / _unit(value)) * _unit(value):.{DIGITS}g}")


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
