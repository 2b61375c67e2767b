"""A simulated person who steers the robot to targets by what there is to see, late and with an unsteady hand.

The crossover model of McRuer & Jex (1967, IEEE Trans. Human Factors in Electronics 8(3), 231 to 249): whatever the
robot, a trained person shapes the loop of both to ω_c e^{−τ_e s}/s around its crossover. For the robot
p̈ = −aṗ − kp + u_h that takes

    u_h = ω_c (s + a + k/s) e^{−τs} / (T s + 1) · (r − p),

r the target: a lead against the robot's lag 1/(s + a), and, where a spring pulls the robot back, a trim that leans
against it. What that leaves of phase and what delay takes it away is in ``passafe_services.operator.human.crossover``.

| parameter | default | seen in people | source |
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
    """Looks at the newest state once a glance, decides, and acts a reaction time later.

    At a glance the error e = r − p and the velocity v are seen, each number with its own ``Remnant``; the target r is
    that of the state's own plant time, as robot and target are on one screen. What is decided then,
    ω_c (a e − v + k∫e), no longer than the authority, is where u_h tends to from one reaction time later on, with time
    constant T. Where the authority ends, ∫e grows no further.

    A person who sees nothing new goes on with what was seen last, and one who sees no robot that moves asks for
    nothing. Between glances u_h is the exact solution of Tu̇_h = decided − u_h, so that what is sent does not depend on
    how often it is asked for; the decided value and with it u_h never leave the ball of the authority.
    """

    device: ClassVar[str] = "human"
    clock: ClassVar[SourceClock] = SourceClock.LOCAL  # a person's delays do not stop when pictures come late
    finished: ClassVar[bool] = False

    def __init__(self, config: HumanSource, robot: SteeredRobot) -> None:
        """Start at rest.

        Args:
            config: The person and the targets, each of ``robot.axes`` numbers.
            robot: What the person has learnt to steer.
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
        self._on_screen: PlantState | None = None
        self._coming: PlantState | None = None
        self._rest: Vector = (0.0,) * robot.axes
        self._next_s = inf
        self._forget()

    def see(self, state: PlantState) -> None:
        """Take what the screen shows from now on."""
        self._coming = state
        if state.phase is WAITING:
            self._forget()

    def command(self, t_s: float) -> Command:
        """Return the command at local time ``t_s``, never smaller than before."""
        if t_s >= self._next_s:
            self._go_through(t_s)
        elif self._next_s == inf:
            if self._coming is None or self._coming.phase is WAITING:
                return Command(self._rest, self._rest, True)
            self._origin_s = self._at_s = self._next_s = t_s
            self._go_through(t_s)
        self._on_screen = self._coming
        left, lag_s = exp((self._at_s - t_s) / self._lag_s), self._lag_s
        u_h, rate = [], []
        for goal, started in zip(self._goal, self._u_h, strict=True):
            missing = (goal - started) * left
            u_h.append(goal - missing)
            rate.append(missing / lag_s)
        return Command(tuple(u_h), tuple(rate), True)

    def _forget(self) -> None:
        """Put the hand and the mind at rest, until the next robot that moves is seen."""
        self._u_h = self._goal = self._rest
        self._trim = [0.0] * self._axes
        self._decided: deque[tuple[float, Vector]] = deque()
        self._glances = 0
        self._origin_s = self._at_s = 0.0
        self._next_s = inf

    def _go_through(self, t_s: float) -> None:
        """Do what is due up to ``t_s``, each glance and each act at its own time."""
        decided = self._decided
        while self._next_s <= t_s:
            now_s = self._next_s
            if decided and decided[0][0] <= now_s:
                self._turn_to(decided.popleft()[1], now_s)
            else:
                # Between two steps the screen still shows what it did at the first.
                state = self._coming if now_s >= t_s or self._on_screen is None else self._on_screen
                if state is not None:
                    decided.append((now_s + self._reaction_s, self._decide(state)))
                self._glances += 1
            glance_s = self._origin_s + self._glances * self._glance_s
            self._next_s = min(glance_s, decided[0][0]) if decided else glance_s

    def _turn_to(self, goal: Vector, now_s: float) -> None:
        left = exp((self._at_s - now_s) / self._lag_s)
        self._u_h = tuple([to + (u - to) * left for to, u in zip(self._goal, self._u_h, strict=True)])
        self._goal, self._at_s = goal, now_s

    def _decide(self, state: PlantState) -> Vector:
        """Return where u_h is to go, from what the screen shows."""
        target = self._target(state.plant_ns / 1e9)
        if target is None:
            return self._rest
        n, x, wrong = self._axes, state.x, self._remnant.step()
        on_error, on_velocity = self._gains
        errors = [(target[i] - x[i]) * (1 + wrong[i]) for i in range(n)]
        leaning = [self._trim_gain * error for error in errors]
        # Half of what this glance adds: the mean over the time for which it is held.
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
        """Position of the newest target at a plant time; None before the first."""
        current = None
        for at_s, position in self._targets:
            if at_s > plant_s:
                break
            current = position
        return current
