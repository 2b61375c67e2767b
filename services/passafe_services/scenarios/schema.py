"""What a scenario file may say: pydantic models with ranges, units in the names, no unknown keys."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from passafe.human_input import PROPORTIONS
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.registry import AnyBarrier
from passafe_services.scenarios.class_k import ClassKConfig
from passafe_services.scenarios.fields import Config, NonNegative, Positive, Vector
from passafe_services.scenarios.link_schema import LinkChangeConfig, LinkName, ScenarioLink, changed_links
from passafe_services.scenarios.robot_models import ROBOT_MODELS, RobotModel
from passafe_services.scenarios.single_barriers import single_barriers
from passafe_services.scenarios.source_schema import Source


class PlantConfig(Config):
    """The robot: a model of the core by name, its parameters and where it starts.

    ``playout_s`` is how long before it takes effect an input should arrive, beyond the longest time that one took
    lately: the buffer that absorbs jitter and loss.
    ``hold_s`` is how long an input stays in force when no other follows, before the fail-safe law takes over; the
    filter's margin between samples covers it, so a long one keeps the robot further from its barriers.
    ``start_low`` and ``start_high`` span the box from which campaigns draw their starts; ±3 where they are not given.
    """

    model: Literal["damped-point", "drag-point", "lagged-point", "saturating-point", "two-points", "joint-chain"]
    parameters: dict[str, float] = Field(default_factory=dict)
    x0: Vector
    playout_s: Annotated[float, Field(ge=0, le=2)] = 0.005
    hold_s: Annotated[float, Field(ge=0, le=0.2)] = 0.01
    start_low: Vector | None = None
    start_high: Vector | None = None

    @property
    def robot_model(self) -> RobotModel:
        """Return the model of that name."""
        return ROBOT_MODELS[self.model]


class AsSentEstimator(Config):
    """The filter takes u_h and its rate as the newest command says them."""

    kind: Literal["as-sent"] = "as-sent"


class WhiteAccelerationEstimator(Config):
    """The filter estimates u_h and its rate from the commands with a Kalman filter whose rate is a random walk.

    ``agility`` is √S, S the density of the second derivative, units of u per s^1.5. ``resolution`` is the step in
    which the device tells u_h, units of u. The newest rate is believed for ``horizon_s``, then it falls to zero in
    ``fade_s``.
    """

    kind: Literal["white-acceleration"]
    agility: Annotated[float, Field(ge=1e-9, le=1e6)]
    resolution: Annotated[float, Field(ge=1e-9, le=1e6)]
    horizon_s: Annotated[float, Field(ge=0, le=1)] = 0.0
    fade_s: Annotated[float, Field(ge=1e-3, le=1)] = 0.2

    @model_validator(mode="after")
    def _in_proportion(self) -> Self:
        least, most = PROPORTIONS
        if not least <= self.agility / self.resolution <= most:
            got = f"{self.agility} with resolution {self.resolution}"
            raise ValueError(f"agility: got {got}, allowed {least:g} to {most:g} times the latter")
        return self


Estimator = Annotated[AsSentEstimator | WhiteAccelerationEstimator, Field(discriminator="kind")]


class OperatorConfig(Config):
    """Who drives, and what the filter makes of it.

    A command older than ``stale_s`` is stale at the filter. Then, and when the dead-man is released, what it asked for
    fades to zero within ``fade_s``.
    """

    source: Source
    stale_s: Positive = 0.2
    fade_s: Annotated[float, Field(ge=0, le=5)] = 0.1
    estimator: Estimator = AsSentEstimator()


class FeedbackConfig(Config):
    """u_fb = −k_p·position − k_d·velocity."""

    k_p: NonNegative = 0.0
    k_d: NonNegative = 0.0


class PassivityConfig(Config):
    """The passivity row: ``power`` keeps the power margin, ``tank`` spends an energy tank.

    ``storage`` is V: ``squared-norm`` ‖x‖², ``kinetic`` ½‖v‖², ``spring`` ½‖v‖² + ½·spring_stiffness_per_s2·‖p‖².
    ``slack_weight`` is ρ_u, the price of one unit of slack squared against one unit of u squared.
    """

    kind: Literal["power", "tank"] = "power"
    storage: Literal["squared-norm", "kinetic", "spring"] = "squared-norm"
    spring_stiffness_per_s2: Positive = 1.0
    slack_weight: Annotated[float, Field(ge=1e3, le=1e9)] = 1e6
    class_k: ClassKConfig = ClassKConfig(kind="linear", gain=100.0)
    tank_initial_j: NonNegative = 1.0
    tank_reserve_j: NonNegative = 0.5
    tank_max_j: Positive = 10.0
    tank_rate_per_s: Positive = 5.0


class FilterConfig(Config):
    """The filter: law, mode, gains, limits of the input, passivity and barriers.

    ``k_i`` is α/2 of the tracking term. ``input_bound`` limits every axis of u, ``input_norm_bound`` its length and
    ``input_rate_bound_per_s`` how fast every axis may change. ``start`` is the input before the first one:
    ``nearest`` lets the first one be the nearest to û that keeps every row, ``zero`` begins at u = 0 as the paper
    does. ``between_samples`` keeps barriers between samples too. ``prediction`` lets the filter decide for the state at
    which its input will take effect; without it, for the newest state that came, however old. ``repeats`` is how many
    earlier inputs each message repeats, as far as 64 numbers hold them.
    """

    law: Literal["sampled", "continuous"] = "sampled"
    mode: Literal["off", "safe", "passive", "both"] = "both"
    k_i: Positive
    input_bound: Positive = 100.0
    input_norm_bound: Positive | None = None
    input_rate_bound_per_s: Positive | None = None
    start: Literal["nearest", "zero"] = "nearest"
    between_samples: bool = True
    feedback: FeedbackConfig = FeedbackConfig()
    passivity: PassivityConfig = PassivityConfig()
    barriers: tuple[AnyBarrier, ...] = ()
    stale_s: Positive = 0.2
    prediction: bool = True
    repeats: Annotated[int, Field(ge=0, le=64)] = 16


class Scenario(Config):
    """One scenario: everything that decides what a run does.

    ``links`` are the impaired links at the start, ``link_changes`` what becomes of them later.
    """

    schema_version: Literal[1]
    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,59}$")]
    title: str
    description: str = ""
    duration_s: Annotated[float, Field(gt=0, le=86_400)]
    rate_hz: Annotated[float, Field(ge=10, le=2000)] = 1000.0
    plant: PlantConfig
    operator: OperatorConfig
    filter: FilterConfig
    links: dict[LinkName, ScenarioLink] = Field(default_factory=dict)
    link_changes: tuple[LinkChangeConfig, ...] = ()

    @property
    def dt_s(self) -> float:
        """Period of one tick, s."""
        return 1.0 / self.rate_hz

    @property
    def barriers(self) -> tuple[SingleBarrier, ...]:
        """Return the filter's barriers with one h each, every one with a name of its own."""
        return single_barriers(self.filter.barriers, self.plant.robot_model)

    @model_validator(mode="after")
    def _barriers_fit_the_model(self) -> Self:
        single_barriers(self.filter.barriers, self.plant.robot_model)
        return self

    @model_validator(mode="after")
    def _link_changes_are_allowed(self) -> Self:
        changed_links(self.links, self.link_changes)
        return self

    @model_validator(mode="after")
    def _tracking_is_stable(self) -> Self:
        if self.filter.k_i * self.dt_s >= 1.0:
            raise ValueError(
                f"filter.k_i: got {self.filter.k_i} at rate_hz {self.rate_hz}, allowed below rate_hz: "
                "a larger gain makes the sampled tracking oscillate"
            )
        return self
