"""Units of what a robot model's input and coordinates are, where the model fixes them."""

from typing import Final

from passafe_services.scenarios.schema import Scenario

_ACCELERATION: Final = "m/s²"

_INPUT_UNITS: Final = {
    "damped-point": _ACCELERATION,
    "drag-point": _ACCELERATION,
    "lagged-point": _ACCELERATION,
    "saturating-point": _ACCELERATION,
    "two-points": _ACCELERATION,
    "joint-chain": "rad/s²",
}
"""Models whose input is written as an acceleration: a force on a unit of mass, a torque on a unit of inertia."""


def input_unit(scenario: Scenario) -> str:
    """Return the unit of u in a scenario; ``units of u`` where its model fixes none."""
    return _INPUT_UNITS.get(scenario.plant.model, "units of u")
