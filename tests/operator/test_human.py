"""The simulated person: what is decided, when it acts, and when the loop with a robot is lost."""

from collections import deque
from collections.abc import Iterable
from math import exp, hypot

import numpy as np
import pytest
from passafe_protocol.messages import PlantPhase, PlantState, Vector
from passafe_services.operator.errors import SourceConfigError
from passafe_services.operator.human.human import SimulatedHuman
from passafe_services.operator.human.steered_robot import SteeredRobot
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.scenario_source import crossover_loop, source_of
from passafe_services.operator.sources.source import ObservingSource, SourceClock
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.source_schema import HumanSource
from scipy.linalg import expm

DT_S = 1e-3
ROBOT = SteeredRobot(axes=2, damping_per_s=3.0, stiffness_per_s2=0.0)


def config_of(**changes: object) -> HumanSource:
    given: dict[str, object] = {"kind": "human", "targets": [{"at_s": 0.0, "position": [1.0, 0.5]}], "remnant": 0.0}
    return HumanSource.model_validate(given | changes)


def state(t_s: float, x: Vector, phase: PlantPhase = PlantPhase.RUNNING) -> PlantState:
    return PlantState(round(t_s * 1e9), x, (), (), 0, phase, 0.0, 0.0, 0, 0, 0, 0.0, 0)


def steer(
    person: SimulatedHuman, robot: SteeredRobot, delay_s: float, duration_s: float, *, sight_s: float = 0.0
) -> np.ndarray:
    """Positions of an exact robot without a filter, a row a millisecond; u_h comes late, or the picture does."""
    k = robot.axes
    generator = np.array([[0, 1, 0], [-robot.stiffness_per_s2, -robot.damping_per_s, 1], [0, 0, 0]])
    ((a, b, c), (d, e, f), _) = expm(generator * DT_S)
    commands = deque([np.zeros(k)] * round(delay_s / DT_S))
    pictures: deque[PlantState] = deque()
    p, v, path = np.zeros(k), np.zeros(k), []
    for i in range(round(duration_s / DT_S)):
        pictures.append(state(i * DT_S, (*p.tolist(), *v.tolist())))
        if len(pictures) > round(sight_s / DT_S):
            person.observe(pictures.popleft())
        commands.append(np.array(person.command(i * DT_S).u_h))
        u = commands.popleft()
        p, v = a * p + b * v + c * u, d * p + e * v + f * u
        path.append(p)
    return np.array(path)


def growth(path: np.ndarray, target: Iterable[float]) -> float:
    """Largest distance in the last fifth over that in the fifth before."""
    distance = np.linalg.norm(path - np.array(list(target)), axis=1)
    fifth = len(distance) // 5
    return float(distance[-fifth:].max() / distance[-2 * fifth : -fifth].max())


def test_command_is_zero_before_the_robot_moves() -> None:
    person = SimulatedHuman(config_of(), ROBOT)
    assert isinstance(person, ObservingSource)
    assert person.clock is SourceClock.LOCAL
    assert person.command(0.0) == Command((0.0, 0.0), (0.0, 0.0), True)
    person.observe(state(0.0, (0.0,) * 4, PlantPhase.WAITING))
    assert person.command(9.0) == Command((0.0, 0.0), (0.0, 0.0), True)


def test_response_follows_a_glance_after_reaction_time_and_lag() -> None:
    """ω_c (a e − v) = 2·(3·(1, 0.5) − (0.1, 0.2)) from 0.2 s on, with the lag of 0.1 s."""
    person = SimulatedHuman(
        config_of(glance_s=0.25, crossover_rad_per_s=2.0, reaction_s=0.2, neuromuscular_s=0.1), ROBOT
    )
    person.observe(state(0.0, (0.0, 0.0, 0.1, 0.2)))
    decided = np.array([5.8, 2.6])

    assert person.command(10.0).u_h == (0.0, 0.0)  # local time, whatever plant time is
    assert person.command(10.2 - 1e-9) == Command((0.0, 0.0), (0.0, 0.0), True)
    command = person.command(10.25)
    assert command.u_h == pytest.approx(decided * (1 - exp(-0.5)))
    assert command.u_h_rate == pytest.approx(decided * exp(-0.5) / 0.1)


def test_command_does_not_depend_on_the_command_rate() -> None:
    asked_often, asked_once = (SimulatedHuman(config_of(remnant=0.01, seed=4), ROBOT) for _ in range(2))
    for person in (asked_often, asked_once):
        person.observe(state(0.0, (0.0,) * 4))
        person.command(0.0)
    for k in range(1, 1000):
        asked_often.command(k * 0.777e-3)

    first, second = asked_often.command(0.777), asked_once.command(0.777)
    assert first.u_h == pytest.approx(second.u_h, rel=1e-12)
    assert first.u_h_rate == pytest.approx(second.u_h_rate, rel=1e-9)


def test_glance_between_steps_sees_the_state_displayed_then() -> None:
    person = SimulatedHuman(config_of(glance_s=0.1, reaction_s=0.02), ROBOT)
    person.observe(state(0.0, (0.0,) * 4))
    person.command(0.0)
    person.observe(state(0.15, (1.0, 0.5, 0.0, 0.0)))  # at the target: nothing more to do, from the next glance on
    person.command(0.15)  # the glance at 0.1 s still saw the robot away from it

    assert person.command(0.2199).u_h_rate[0] > 0
    assert person.command(0.2201).u_h_rate[0] < 0


def test_the_rate_is_the_derivative() -> None:
    person = SimulatedHuman(config_of(remnant=0.01), ROBOT)
    person.observe(state(0.0, (0.0,) * 4))
    person.command(0.0)
    before, at, after = (person.command(0.3051 + step) for step in (0.0, 1e-6, 2e-6))

    slope = (np.array(after.u_h) - np.array(before.u_h)) / 2e-6
    assert at.u_h_rate == pytest.approx(slope, rel=1e-5)
    assert np.abs(slope).min() > 1.0


def test_authority_bounds_commands_and_keeps_their_direction() -> None:
    person = SimulatedHuman(
        config_of(targets=[{"at_s": 0, "position": [300.0, 400.0]}], authority=5.0, remnant=0.1), ROBOT
    )
    person.observe(state(0.0, (0.0,) * 4))
    lengths = [hypot(*person.command(k * 0.01).u_h) for k in range(400)]
    assert max(lengths) <= 5.0 * (1 + 1e-12)

    steady = SimulatedHuman(config_of(targets=[{"at_s": 0, "position": [300.0, 400.0]}], authority=5.0), ROBOT)
    steady.observe(state(0.0, (0.0,) * 4))
    steady.command(0.0)
    assert steady.command(5.0).u_h == pytest.approx((3.0, 4.0))


def test_targets_follow_the_plant_time_of_what_is_seen() -> None:
    targets = [{"at_s": 1.0, "position": [1.0, 0.0]}, {"at_s": 2.0, "position": [0.0, 1.0]}]
    settled = []
    for plant_s in (0.999, 1.0, 1.999, 2.0):
        person = SimulatedHuman(config_of(targets=targets), ROBOT)
        person.observe(state(plant_s, (0.0,) * 4))
        person.command(0.0)
        settled.append(person.command(9.0).u_h)

    assert settled[0] == (0.0, 0.0)
    assert settled[1] == settled[2] == pytest.approx((6.0, 0.0))
    assert settled[3] == pytest.approx((0.0, 6.0))


def test_a_robot_that_starts_again_finds_a_person_at_rest() -> None:
    person = SimulatedHuman(config_of(), ROBOT)
    person.observe(state(0.0, (0.0,) * 4))
    person.command(0.0)
    assert person.command(1.0).u_h[0] > 1
    person.observe(state(0.0, (0.0,) * 4, PlantPhase.WAITING))
    assert person.command(1.1) == Command((0.0, 0.0), (0.0, 0.0), True)
    person.observe(state(0.0, (0.0,) * 4))
    assert person.command(1.2).u_h == (0.0, 0.0)
    assert person.command(1.4).u_h == (0.0, 0.0)
    assert person.command(1.5).u_h[0] > 1


def test_a_seed_decides_everything() -> None:
    paths = [steer(SimulatedHuman(config_of(remnant=0.01, seed=seed), ROBOT), ROBOT, 0.0, 1.0) for seed in (1, 1, 2)]

    assert np.array_equal(paths[0], paths[1])
    assert not np.array_equal(paths[0], paths[2])


@pytest.mark.parametrize(
    ("damping", "stiffness", "omega"), [(2.0, 0.0, 2.0), (1.0, 0.0, 3.0), (6.0, 10.0, 2.0), (2.0, 0.0, 1.0)]
)
def test_the_loop_is_lost_at_the_delay_that_its_margin_predicts(damping: float, stiffness: float, omega: float) -> None:
    config = config_of(
        targets=[{"at_s": 0, "position": [1.0]}], crossover_rad_per_s=omega, authority=1e6, tolerance_m=0.1
    )
    robot = SteeredRobot(axes=1, damping_per_s=damping, stiffness_per_s2=stiffness)
    margin_s = crossover_loop(config).delay_margin_s

    assert growth(steer(SimulatedHuman(config, robot), robot, 0.98 * margin_s, 40.0), [1.0]) < 1.0
    assert growth(steer(SimulatedHuman(config, robot), robot, 1.02 * margin_s, 40.0), [1.0]) > 1.0


def test_a_late_picture_is_as_bad_as_a_late_command() -> None:
    config = config_of(authority=1e6)
    late_s = 1.05 * crossover_loop(config).delay_margin_s

    assert growth(steer(SimulatedHuman(config, ROBOT), ROBOT, 0.0, 40.0, sight_s=late_s), [1.0, 0.5]) > 1.0
    assert growth(steer(SimulatedHuman(config, ROBOT), ROBOT, 0.0, 40.0, sight_s=0.9 * late_s), [1.0, 0.5]) < 1.0


@pytest.mark.parametrize(("damping", "stiffness"), [(2.0, 0.0), (6.0, 10.0)])
def test_without_network_delay_the_target_is_reached(damping: float, stiffness: float) -> None:
    robot = SteeredRobot(axes=2, damping_per_s=damping, stiffness_per_s2=stiffness)
    path = steer(SimulatedHuman(config_of(remnant=0.01), robot), robot, 0.0, 8.0)

    assert np.abs(path[-1000:] - (1.0, 0.5)).max() < 0.02


def test_saturated_trim_unwinds_when_the_target_is_passed() -> None:
    """A spring that the authority cannot hold at the target: integrated on, the trim would keep it there for long."""
    robot = SteeredRobot(axes=1, damping_per_s=6.0, stiffness_per_s2=10.0)
    targets = [{"at_s": 0, "position": [3.0]}, {"at_s": 20.0, "position": [0.5]}]
    path = steer(SimulatedHuman(config_of(targets=targets, authority=15.0), robot), robot, 0.0, 26.0)

    assert path[19_999, 0] == pytest.approx(1.5, abs=1e-3)
    assert path[-1, 0] == pytest.approx(0.5, abs=0.02)


def shown(person: SimulatedHuman, x: Vector, from_s: float, until_s: float) -> Vector:
    """u_h after the person has looked at one state for a while, glance by glance."""
    u_h: Vector = ()
    for k in range(round(from_s / 0.02), round(until_s / 0.02) + 1):
        person.observe(state(k * 0.02, x))
        u_h = person.command(k * 0.02).u_h
    return u_h


SPRING = SteeredRobot(axes=1, damping_per_s=6.0, stiffness_per_s2=10.0)


def test_trim_integrates_the_error_at_mid_glance() -> None:
    """ω_c (a e + k ∫e), e = 0.1, at the second of two glances of 0.25 s: ∫e is 1.5 glances."""
    config = config_of(targets=[{"at_s": 0, "position": [0.1]}], glance_s=0.25, neuromuscular_s=0.01)
    person = SimulatedHuman(config, SPRING)
    person.observe(state(0.0, (0.0, 0.0)))
    person.command(0.0)

    assert person.command(0.69).u_h[0] == pytest.approx(2 * (6 * 0.1 + 10 * 0.1 * 1.5 * 0.25), rel=1e-6)


def test_trim_beyond_the_authority_returns_when_the_error_turns() -> None:
    """While the robot rushes, the trim grows; then it is wound up by 8 and unwinds by ω_c k e = 1 a second."""
    person = SimulatedHuman(config_of(targets=[{"at_s": 0, "position": [1.0]}], authority=15.0), SPRING)
    assert shown(person, (0.0, 10.0), 0.0, 5.0)[0] == pytest.approx(15.0, abs=0.3)
    assert shown(person, (1.05, 0.0), 5.02, 10.0) == pytest.approx((15.0,))
    assert shown(person, (1.05, 0.0), 10.02, 20.0)[0] < 10.0


def test_steered_robot_is_that_of_the_scenario() -> None:
    assert SteeredRobot.of(load_scenario("notomista-cai-2020")) == SteeredRobot(
        axes=2, damping_per_s=6.0, stiffness_per_s2=10.0
    )
    two = SteeredRobot.of(load_scenario("two-robots"))
    assert (two.axes, two.damping_per_s, two.stiffness_per_s2) == (4, 5.0, 4.0)


def test_a_robot_that_lags_is_refused() -> None:
    person = {"kind": "human", "targets": [{"at_s": 0, "position": [1.0, 1.0]}]}
    with pytest.raises(SourceConfigError, match=r"operator\.source\.kind: got 'human with a lagged-point'"):
        source_of(load_scenario("lagged-point", {"operator.source": person}))


@pytest.mark.parametrize("position", [[1.0], [1.0, 2.0, 3.0], [1.0, 2e6]])
def test_a_target_that_does_not_fit_is_named(position: list[float]) -> None:
    person = {"kind": "human", "targets": [{"at_s": 0, "position": [0.0, 0.0]}, {"at_s": 1, "position": position}]}
    with pytest.raises(SourceConfigError) as caught:
        source_of(load_scenario("walls-and-disks", {"operator.source": person}))
    assert caught.value.field == "targets[1].position"


def test_targets_come_one_after_the_other() -> None:
    with pytest.raises(ValueError, match="strictly increasing"):
        config_of(targets=[{"at_s": 1, "position": [0.0]}, {"at_s": 1, "position": [1.0]}])
