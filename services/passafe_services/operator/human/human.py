"""Simulated person who steers the robot to targets by sight, with reaction time, arm lag and remnant.

The crossover model of McRuer & Jex (1967, IEEE Trans. Human Factors in Electronics 8(3), 231 to 249): whatever the
robot, a trained person shapes the loop of both to ω_c e^{−τ_e s}/s around its crossover. For the robot
p̈ = −aṗ − kp + u_h this requires

    u_h = ω_c (s + a + k/s) e^{−τs} / (T s + 1) · (r − p),

r the target: a lead that compensates the robot's lag 1/(s + a), and a trim that compensates a spring. Phase and delay
margins are in ``passafe_services.operator.human.crossover``.

| parameter | default | observed in people | source |
|---|---|---|---|
| ω_c, ``crossover_rad_per_s`` | 2 rad/s | 2 to 5, less for robots that need lead | McRuer & Jex 1967 |
| τ, ``reaction_s`` | 0.2 s | 0.1 to 0.3, pure delay | McRuer & Krendel 1974, AGARDograph 188 |
| T, ``neuromuscular_s`` | 0.1 s | 0.1 to 0.2; the precision model's T_N | the same; Kleinman, Baron & Levison 1970 |
| ρ, ``remnant`` | 0.01 s/rad | −20 dB | Levison, Baron & Kleinman 1969 |
"""

from collections import deque
from math import exp, hypot, inf
from typing import ClassVar, Final

from passafe_protocol.messages import PlantPhase, PlantState, Vector

from passafe_services.operator.human.remnant import Remnant
from passafe_services.operator.human.steered_robot import SteeredRobot
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock
from passafe_services.scenarios.source_schema import HumanSource

WAITING: Final = PlantPhase.WAITING


class SimulatedHuman:
    """Observes the newest state at every glance, decides, and acts one reaction time later.

    At a glance the error e = r − p and the velocity v are observed, each coordinate with its own ``Remnant``; the
    target r is that of the state's plant time, as robot and target are on one screen. The decision
    ω_c (a e − v + k∫e), limited to the authority, is the goal of u_h one reaction time later, approached with time
    constant T. At the limit of the authority, ∫e is not integrated further (anti-windup).

    Without a new state the last one is used, and before a moving robot is seen u_h is zero. Between glances u_h is the
    exact solution of Tu̇_h = goal − u_h, so that it does not depend on the rate of the commands; the goal and hence u_h
    never leave the ball of the authority.
    """

    device: ClassVar[str] = "human"
    clock: ClassVar[SourceClock] = SourceClock.LOCAL  # a person's delays continue when pictures arrive late
    finished: ClassVar[bool] = False

    def __init__(self, config: HumanSource, robot: SteeredRobot) -> None:
        """Start at rest.

        Args:
            config: The person and the targets, each of ``robot.axes`` numbers.
            robot: Robot that the person has learnt to steer.
        """
        omega = config.crossover_rad_per_s
        self._gains = omega * robot.damping_per_s, -omega
        self._trim_gain = omega * robot.stiffness_per_s2 * config.glance_s
        self._reaction_s, self._glance_s = config.reaction_s, config.glance_s
        self._lag_s, self._authority = config.neuromuscular_s, config.authority
        self._targets = [(target.at_s, target.position) for target in config.targets]
        self._axes = robot.axes
        self._remnant = Remnant(
            ratio=config.remnant,
            bandwidth_rad_per_s=config.remnant_bandwidth_rad_per_s,
            glance_s=config.glance_s,
            count=2 * robot.axes,
            seed=config.seed,
        )
        self._displayed: PlantState | None = None
        self._newest: PlantState | None = None
        self._rest: Vector = (0.0,) * robot.axes
        self._next_s = inf
        self._reset()

    def observe(self, state: PlantState) -> None:
        """Update the display."""
        self._newest = state
        if state.phase is WAITING:
            self._reset()

    def command(self, t_s: float) -> Command:
        """Return the command at local time ``t_s``, which is non-decreasing."""
        if t_s >= self._next_s:
            self._process_until(t_s)
        elif self._next_s == inf:
            if self._newest is None or self._newest.phase is WAITING:
                return Command(self._rest, self._rest, True)
            self._origin_s = self._at_s = self._next_s = t_s
            self._process_until(t_s)
        self._displayed = self._newest
        left, lag_s = exp((self._at_s - t_s) / self._lag_s), self._lag_s
        u_h, rate = [], []
        for goal, started in zip(self._goal, self._u_h, strict=True):
            missing = (goal - started) * left
            u_h.append(goal - missing)
            rate.append(missing / lag_s)
        return Command(tuple(u_h), tuple(rate), True)

    def _reset(self) -> None:
        """Reset hand and decisions until a moving robot is seen again."""
        self._u_h = self._goal = self._rest
        self._trim = [0.0] * self._axes
        self._decided: deque[tuple[float, Vector]] = deque()
        self._glances = 0
        self._origin_s = self._at_s = 0.0
        self._next_s = inf

    def _process_until(self, t_s: float) -> None:
        """Process glances and actions up to ``t_s``, each at its own time."""
        decided = self._decided
        while self._next_s <= t_s:
            now_s = self._next_s
            if decided and decided[0][0] <= now_s:
                self._set_goal(decided.popleft()[1], now_s)
            else:
                # Between two steps the display still shows the state of the first one.
                state = self._newest if now_s >= t_s or self._displayed is None else self._displayed
                if state is not None:
                    decided.append((now_s + self._reaction_s, self._decide(state)))
                self._glances += 1
            glance_s = self._origin_s + self._glances * self._glance_s
            self._next_s = min(glance_s, decided[0][0]) if decided else glance_s

    def _set_goal(self, goal: Vector, now_s: float) -> None:
        left = exp((self._at_s - now_s) / self._lag_s)
        self._u_h = tuple([to + (u - to) * left for to, u in zip(self._goal, self._u_h, strict=True)])
        self._goal, self._at_s = goal, now_s

    def _decide(self, state: PlantState) -> Vector:
        """Return the goal of u_h from the displayed state."""
        target = self._target(state.plant_ns / 1e9)
        if target is None:
            return self._rest
        n, x, wrong = self._axes, state.x, self._remnant.step()
        on_error, on_velocity = self._gains
        errors = [(target[i] - x[i]) * (1 + wrong[i]) for i in range(n)]
        leaning = [self._trim_gain * error for error in errors]
        # Half of this glance's increment: its mean over the hold time.
        wanted = [
            on_error * errors[i] + on_velocity * x[n + i] * (1 + wrong[n + i]) + self._trim[i] + leaning[i] / 2
            for i in range(n)
        ]
        length = hypot(*wanted)
        saturated = length > self._authority
        if not (saturated and sum(e * w for e, w in zip(errors, wanted, strict=True)) > 0):
            self._trim = [trim + more for trim, more in zip(self._trim, leaning, strict=True)]
        if not saturated:
            return tuple(wanted)
        share = self._authority / length
        return tuple([share * value for value in wanted])

    def _target(self, plant_s: float) -> Vector | None:
        """Return the position of the current target at a plant time; ``None`` before the first."""
        current = None
        for at_s, position in self._targets:
            if at_s > plant_s:
                break
            current = position
        return current
