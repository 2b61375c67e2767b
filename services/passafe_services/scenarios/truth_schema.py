"""The simulated robot as it really is, where it is not its model: known to no filter."""

from typing import Annotated, Literal

from pydantic import Field

from passafe_services.scenarios.fields import Config, Finite
from passafe_services.scenarios.state_numbers import BoundPerState, PerState
from passafe_services.scenarios.uncertainty_schema import LagS

Seed = Annotated[int, Field(ge=0, le=2**63 - 1)]


class ConstantDisturbance(Config):
    """A disturbance that stays.

    Attributes:
        kind: ``constant``.
        rate: What is added to each state's rate, state units per s.
    """

    kind: Literal["constant"]
    rate: PerState


class SwitchingDisturbance(Config):
    """A disturbance of full size whose signs are drawn anew now and then.

    Attributes:
        kind: ``switching``.
        bound: Magnitude for each state's rate, state units per s.
        every_s: Time between draws, s.
        seed: Of the draws.
    """

    kind: Literal["switching"]
    bound: BoundPerState
    every_s: Annotated[float, Field(ge=1e-3, le=100)] = 0.5
    seed: Seed = 0


class SineDisturbance(Config):
    """A disturbance that swings; each state's is a quarter of a period behind the one before.

    Attributes:
        kind: ``sine``.
        bound: Amplitude for each state's rate, state units per s.
        period_s: Period, s.
    """

    kind: Literal["sine"]
    bound: BoundPerState
    period_s: Annotated[float, Field(ge=1e-2, le=1000)] = 1.0


class GreedyDisturbance(Config):
    """A disturbance of full size that pushes towards the barrier which is nearest to be lost.

    Attributes:
        kind: ``greedy``.
        bound: Magnitude for each state's rate, state units per s.
    """

    kind: Literal["greedy"]
    bound: BoundPerState


Disturbance = Annotated[
    ConstantDisturbance | SwitchingDisturbance | SineDisturbance | GreedyDisturbance, Field(discriminator="kind")
]


class NoiseConfig(Config):
    """Noise of the states as they are read, uniform and white.

    Attributes:
        bound: Largest magnitude for each state, state units.
        seed: Of the draws.
    """

    bound: BoundPerState
    seed: Seed = 0


class TruthConfig(Config):
    """Truth of the simulated robot, where it is not its model. The filter does not know it; review and log do.

    Attributes:
        parameters: Parameters of the robot by name, where they are not the model's.
        disturbance: What acts on it besides its input; held over each period.
        noise: Of the states that it reports.
        quantisation: Steps of the states that it reports, state units; 0 for none.
        actuator_lag_s: First-order lag between the input and the one that acts, s.
    """

    parameters: dict[str, Finite] = Field(default_factory=dict)
    disturbance: Disturbance | None = None
    noise: NoiseConfig | None = None
    quantisation: BoundPerState | None = None
    actuator_lag_s: LagS = 0.0
