"""Sets of what the robot may do otherwise than its model, and the guard at the plant, in scenario files."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from passafe_services.scenarios.fields import Config, Finite
from passafe_services.scenarios.state_numbers import BoundPerState, StateBounds

Interval = Annotated[tuple[Finite, ...], Field(min_length=2, max_length=2)]
LagS = Annotated[float, Field(ge=0, le=1)]


class UncertaintyConfig(Config):
    """Sets for whose every member the rows hold; a robot outside of them is a violation of the model.

    Attributes:
        parameters: Least and largest value of parameters of the model, by name; the interval contains the model's.
        disturbance: Largest magnitude of a disturbance on each state's rate, state units per s.
        state_error: Largest error of each state as it is read, state units: noise, quantisation.
        actuator_lag_s: Largest first-order lag of the actuators, s; it takes limits of the rates of all inputs.
        in_filter: Whether the filter's rows hold for the sets. If not, the sets are watched, and hold at the guard.
    """

    parameters: dict[str, Interval] = Field(default_factory=dict)
    disturbance: BoundPerState = StateBounds()
    state_error: BoundPerState = StateBounds()
    actuator_lag_s: LagS = 0.0
    in_filter: bool = True

    @model_validator(mode="after")
    def _intervals_are_ordered(self) -> Self:
        for name, (low, high) in self.parameters.items():
            if low > high:
                raise ValueError(f"parameters.{name}: got [{low:g}, {high:g}], allowed the lower number first")
        return self


class GuardConfig(Config):
    """The guard at the plant: the same rows once more, on the plant's own state, as the last thing before the actuator.

    Attributes:
        enabled: Whether there is one.
        state_error: Largest error of each state as the guard reads it; that of the scenario's sets if not given.
    """

    enabled: bool = True
    state_error: BoundPerState | None = None
