"""Schema of scenario files: pydantic models with ranges and units in the names, unknown keys refused."""

from functools import partial
from typing import Annotated, Literal, Self

from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator

from passafe.human_input import PROPORTIONS
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.registry import AnyBarrier
from passafe_services.scenarios.class_k import ClassKConfig
from passafe_services.scenarios.driver_schema import DriverConfig, ModelDriverConfig
from passafe_services.scenarios.fields import Config, NonNegative, Positive, Vector, no_flag
from passafe_services.scenarios.limits_schema import InputLimitsConfig
from passafe_services.scenarios.link_schema import LinkChangeConfig, LinkName, ScenarioLink, changed_links
from passafe_services.scenarios.robot_models import ROBOT_MODELS, RobotModel
from passafe_services.scenarios.robots.carried_robot import CarriedRobot, built_robot
from passafe_services.scenarios.robots.robot_source import installed_robots
from passafe_services.scenarios.robots.shipped import SHIPPED
from passafe_services.scenarios.single_barriers import single_barriers
from passafe_services.scenarios.source_schema import SourceConfig
from passafe_services.scenarios.truth_schema import TruthConfig
from passafe_services.scenarios.uncertainty_schema import GuardConfig, UncertaintyConfig
from passafe_services.suggestion import suggestion


class PlantConfig(Config):
    """The robot: a model of the core, its parameters and its start.

    Attributes:
        robot: A robot that is not of the core, as data: written by passafe into effective scenarios and logs, never
            by hand.
        model: Robot model of the core, or a robot of an installed distribution (``docs/how-to/own-robot.md``).
        parameters: Its parameters by name.
        x0: Initial state: positions, then velocities, m and m/s or rad and rad/s.
        playout_s: How long before its effect an input should arrive, s, beyond the largest recent transit time: the
            buffer that absorbs jitter and loss.
        hold_s: How long an input stays in force when no other follows, s, before the fail-safe law takes over. The
            intersample margin covers it, so a long hold keeps the robot further from its barriers.
        start_low: Lowest corner of the box from which campaigns draw their starts; −3 by default.
        start_high: Highest corner; 3 by default.
        driver: What reads and moves the robot; its exact model by default.
        truth: What the simulated robot really is, where it is not its model.
        guard: Guard at the plant; none if not given.
    """

    robot: CarriedRobot | None = None
    model: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,59}$")]
    parameters: dict[str, float] = Field(default_factory=dict)
    x0: Vector
    playout_s: Annotated[float, Field(ge=0, le=2)] = 0.005
    hold_s: Annotated[float, Field(ge=0, le=0.2)] = 0.01
    start_low: Vector | None = None
    start_high: Vector | None = None
    driver: DriverConfig = ModelDriverConfig()
    truth: TruthConfig | None = None
    guard: GuardConfig | None = None

    @property
    def robot_model(self) -> RobotModel:
        """Return the model of that name, or that of the robot that the scenario carries."""
        if self.robot is None:
            return ROBOT_MODELS[self.model]
        return RobotModel(
            name=self.model,
            build=partial(built_robot, self.robot),
            parameters=tuple({**self.robot.built_with, **self.robot.parameters}),
            points=self.robot.points,
            commands=self.robot.commands,
            spheres=tuple(sphere.name for sphere in self.robot.spheres),
            position_unit=self.robot.position_unit,
            input_unit=self.robot.input_unit or "units of u",
        )

    @field_validator("model", mode="after")
    @classmethod
    def _is_known(cls, model: str, info: ValidationInfo) -> str:
        if info.data.get("robot") is None and model not in ROBOT_MODELS:
            names = (*ROBOT_MODELS, *SHIPPED, *installed_robots())
            installed = ", ".join(installed_robots()) or "none"
            listed = f"{', '.join(map(repr, names))}, or any with --robot (installed by others: {installed})"
            raise ValueError(f"got {model!r}, allowed {listed}{suggestion(model, names)}")
        return model


class AsSentEstimator(Config):
    """Pass-through: u_h and its rate are those of the newest command."""

    kind: Literal["as-sent"] = "as-sent"


class WhiteAccelerationEstimator(Config):
    """Kalman filter of the commands, whose rate is a random walk.

    Attributes:
        agility: √S, S the spectral density of the second derivative of u_h, units of u per s^1.5.
        resolution: Quantisation step of the device, units of u.
        horizon_s: How long the newest rate is trusted in full, s.
        fade_s: How long the rate then takes to fall to zero, s.
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
    """The operator: source of the commands and their treatment at the filter.

    Attributes:
        source: Script, device, simulated person or adversary.
        stale_s: Age above which a command counts no more at the filter, s; the time on the way is part of it.
        fade_s: Time in which the request then fades to zero, s; also after a release of the dead-man switch.
        resume_s: Time in which the request ramps in when commands count again after it faded to zero, s; less if it
            had faded less.
        estimator: Derivation of u_h and its rate from the commands.
    """

    source: SourceConfig
    stale_s: Positive = 0.2
    fade_s: Annotated[float, Field(ge=0, le=5)] = 0.1
    resume_s: Annotated[float, Field(ge=0.01, le=10)] = 0.5
    estimator: Estimator = AsSentEstimator()


class FeedbackConfig(Config):
    """The state feedback u_fb = −k_p·position − k_d·velocity, or any expression that the robot brings.

    Attributes:
        kind: ``gains``, or ``own`` for the robot's own.
        k_p: Proportional gain, 1/s².
        k_d: Derivative gain, 1/s.
    """

    kind: Literal["gains", "own"] = "gains"
    k_p: NonNegative = 0.0
    k_d: NonNegative = 0.0


class PassivityConfig(Config):
    """The passivity row.

    Attributes:
        kind: ``power`` bounds the power margin, ``tank`` spends an energy tank.
        storage: V: ``squared-norm`` ‖x‖², ``kinetic`` ½‖v‖², ``spring`` ½‖v‖² + ½·spring_stiffness_per_s2·‖p‖²,
            ``own`` the robot's own.
        spring_stiffness_per_s2: Stiffness of the spring in V, 1/s².
        slack_weight: ρ_u, the cost of one unit of slack squared against one unit of u squared.
        class_k: γ_u, of the continuous law only.
        tank_initial_j: Tank level at the start, J.
        tank_reserve_j: Level below which only safety may draw, J.
        tank_max_j: Largest level, J.
        tank_rate_per_s: κ, 1/s: how fast the tank may be emptied towards the reserve.
    """

    kind: Literal["power", "tank"] = "power"
    storage: Literal["squared-norm", "kinetic", "spring", "own"] = "squared-norm"
    spring_stiffness_per_s2: Positive = 1.0
    slack_weight: Annotated[float, Field(ge=1e3, le=1e9)] = 1e6
    class_k: ClassKConfig = ClassKConfig(kind="linear", gain=100.0)
    tank_initial_j: NonNegative = 1.0
    tank_reserve_j: NonNegative = 0.5
    tank_max_j: Positive = 10.0
    tank_rate_per_s: Positive = 5.0


class LawConfig(Config):
    """The filter's law, what it enforces, and how fast it follows.

    Attributes:
        law: Rows of the quadratic program: ``sampled``, or ``continuous`` as in the paper.
        mode: What is enforced.
        k_i: Tracking gain α/2, 1/s, below ``rate_hz``.
    """

    law: Literal["sampled", "continuous"] = "sampled"
    mode: Literal["off", "safe", "passive", "both"] = "both"
    k_i: Positive


class FilterConfig(InputLimitsConfig, LawConfig):
    """The filter: law, mode, gains, input limits, passivity and barriers.

    Attributes:
        start: The input before the first one: ``nearest`` lets the first be the nearest to û that satisfies every row,
            ``zero`` begins at u = 0 as the paper does.
        between_samples: Whether rows have the intersample margin.
        gatekeeper: Whether an input is sent only if from where it leads the fail-safe is proven to keep every barrier.
        feedback: u_fb.
        passivity: The passivity row.
        barriers: The safe set, one entry per barrier.
        stale_s: Time without a newer plant state after which the filter sends nothing, s.
        prediction: Whether the filter decides for the state at which its input will take effect; without it, for the
            newest state received, however old.
        repeats: Earlier inputs that each message repeats, as far as 64 numbers hold them.
    """

    start: Literal["nearest", "zero"] = "nearest"
    between_samples: bool = True
    gatekeeper: bool = False
    feedback: FeedbackConfig = FeedbackConfig()
    passivity: PassivityConfig = PassivityConfig()
    barriers: tuple[AnyBarrier, ...] = ()
    stale_s: Positive = 0.2
    prediction: bool = True
    repeats: Annotated[int, Field(ge=0, le=64)] = 16


class Scenario(Config):
    """One scenario: everything that decides what a run does.

    Attributes:
        schema_version: Version of the file format.
        name: Short name: lower case, digits and dashes.
        title: One line.
        description: More text.
        duration_s: Plant time to run, s.
        rate_hz: Ticks per second of operator, filter and plant, Hz.
        plant: The robot.
        operator: Who drives.
        filter: The filter.
        uncertainty: Sets of what the robot may do otherwise than its model; none if it is its model.
        links: Impaired links at the start, by name.
        link_changes: Planned changes of links.
    """

    schema_version: Annotated[Literal[1], BeforeValidator(no_flag)]
    name: Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]{0,59}$")]
    title: str
    description: str = ""
    duration_s: Annotated[float, Field(gt=0, le=86_400)]
    rate_hz: Annotated[float, Field(ge=10, le=2000)] = 1000.0
    plant: PlantConfig
    operator: OperatorConfig
    filter: FilterConfig
    uncertainty: UncertaintyConfig | None = None
    links: dict[LinkName, ScenarioLink] = Field(default_factory=dict)
    link_changes: tuple[LinkChangeConfig, ...] = ()

    @property
    def dt_s(self) -> float:
        """Period of one tick, s."""
        return 1.0 / self.rate_hz

    @property
    def has_guard(self) -> bool:
        """Return whether there is a guard at the plant."""
        return self.plant.guard is not None and self.plant.guard.enabled

    @property
    def is_exact(self) -> bool:
        """Return whether the plant moves as its model does under the inputs of the filter, to the last bit."""
        is_model = self.plant.driver.kind == "model" and self.plant.truth is None
        return is_model and self.uncertainty is None and not self.has_guard

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
