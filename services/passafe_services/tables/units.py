"""Units of the columns whose names carry none: those of the scenario's robot and barriers."""

from collections.abc import Mapping
from typing import Final

from passafe_services.scenarios.schema import Scenario

_STATES: Final = ("x", "x_hat")
_INPUTS: Final = ("u", "u_h", "u_nominal", "phi", "v", "override_held_back", "override_distance_to_infeasibility")
_OF_ROWS: Final = ("margin", "relaxed")
_WATTS: Final = ("power_margin", "slack")
_POWERS: Final = {0: "", 1: "/s", 2: "/s²", 3: "/s³", 4: "/s⁴"}


def units_of(scenario: Scenario | None) -> Mapping[str, str]:
    """Return units by stem of a column's name, such as ``x_1``, ``u``, ``barrier disk psi_0`` or ``row margin``.

    Args:
        scenario: Scenario of the log; without one no unit is known.
    """
    if scenario is None:
        return {}
    model = scenario.plant.robot_model
    states = len(scenario.plant.x0)
    places = 2 * model.points or states // 2
    blocks = [model.position_unit] * places + [f"{model.position_unit}/s"] * places
    blocks += [model.input_unit] * (states - len(blocks))  # what follows positions and velocities acts like an input
    if scenario.plant.robot is not None:
        blocks = list(scenario.plant.robot.state_units)
    units = {f"{stem}_{k}": unit for stem in _STATES for k, unit in enumerate(blocks, start=1)}
    units |= dict.fromkeys(_INPUTS, model.input_unit) | {"u_h_rate": _per_second(model.input_unit)}
    units |= dict.fromkeys(_WATTS, "W") | {f"row {field}": model.input_unit for field in _OF_ROWS}
    for barrier in scenario.barriers:
        for k, power in _POWERS.items():
            units[f"barrier {barrier.name} psi_{k}"] = barrier.h_unit + power if k == 0 else _per(barrier.h_unit, k)
    return units


def _per_second(unit: str) -> str:
    return _per(unit, 1)


def _per(unit: str, times: int) -> str:
    """Return a unit divided by seconds, so many times, without a second stroke."""
    numerator, _, denominator = unit.partition("/")
    already = {"": 0, "s": 1, "s²": 2, "s³": 3}.get(denominator)
    return (
        f"{unit}{_POWERS[times]}"
        if already is None
        else f"{numerator}{_POWERS.get(already + times, f'/s^{already + times}')}"
    )
