"""Operators who want the robot to fail: what they ask for, and that it follows from what they can know."""

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest
from passafe_protocol.messages import PlantPhase, PlantState, Vector
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.disturbances import HIGHEST_HZ, SWEEP_S, bang_bang_period_s
from passafe_services.operator.sources.scenario_source import source_of
from passafe_services.operator.sources.source import CommandSource, ObservingSource, SourceClock
from passafe_services.operator.sources.worst_direction import against_h
from passafe_services.scenarios.load import load_scenario

from passafe.barrier_chain import Barrier, derive_chain
from passafe.class_k import Linear
from passafe.models.damped_point import damped_point

STRATEGIES = ("piecewise-constant", "chirp", "bang-bang", "against-h", "against-the-tank")
STRENGTH = 20.0


def adversary(strategy: str, scenario: str = "notomista-cai-2020", **changes: object) -> CommandSource:
    config = {"kind": "adversary", "strategy": strategy} | changes
    return source_of(load_scenario(scenario, {"operator.source": config}))


def push(source: CommandSource, x: Vector, u: Vector = (0.0, 0.0), plant_s: float = 0.0, t_s: float = 0.0) -> Vector:
    assert isinstance(source, ObservingSource)
    source.observe(PlantState(round(plant_s * 1e9), x, (), u, 0, PlantPhase.RUNNING, 0.0, 0.0, 0, 0, 0, 0.0, 0))
    return source.command(t_s).u_h


@pytest.mark.parametrize("strategy", STRATEGIES)
def test_they_ask_for_their_strength_and_no_more(strategy: str) -> None:
    source = adversary(strategy, strength=7.0, seed=3)
    rng = np.random.default_rng(1)
    asked = []
    for k in range(2000):
        if isinstance(source, ObservingSource):
            push(source, tuple(rng.uniform(-3, 3, 4)), tuple(rng.uniform(-9, 9, 2)))
        asked.append(source.command(k * 0.01).u_h)

    assert source.device == "adversary"
    assert source.clock is SourceClock.PLANT
    assert np.abs(asked).max() <= 7.0 * (1 + 1e-12)
    assert np.abs(asked).max() > 7.0 * (0.25 if strategy == "chirp" else 0.9)


@pytest.mark.parametrize("strategy", ["piecewise-constant", "chirp", "bang-bang"])
def test_a_seed_decides_them(strategy: str) -> None:
    times = np.linspace(0, 15, 200)
    first, same, other = ([adversary(strategy, seed=seed).command(t_s).u_h for t_s in times] for seed in (5, 5, 6))
    assert first == same
    assert first != other


def test_random_steps_do_not_depend_on_the_command_times() -> None:
    """Forwards in small steps, backwards, and at once in the middle: the same steps."""
    times = [k * 0.05 for k in range(400)]
    forwards, backwards = adversary("piecewise-constant"), adversary("piecewise-constant")
    asked = [forwards.command(t_s).u_h for t_s in times]

    assert [backwards.command(t_s).u_h for t_s in reversed(times)] == asked[::-1]
    assert adversary("piecewise-constant").command(times[321]).u_h == asked[321]
    changes = sum(a != b for a, b in pairwise(asked))
    assert 8 <= changes <= 33  # 20 in 20 s, three standard deviations


def test_chirp_sweeps_its_frequencies_with_the_exact_rate() -> None:
    chirp = adversary("chirp", seed=2)
    step_s = 1e-6
    for t_s in (0.0, 3.0, 9.9, 17.0):
        before, now, after = (chirp.command(t_s + k * step_s) for k in range(3))
        slope = (np.array(after.u_h) - np.array(before.u_h)) / (2 * step_s)
        bend = (np.array(after.u_h) - 2 * np.array(now.u_h) + np.array(before.u_h)) / step_s**2
        assert now.u_h_rate == pytest.approx(slope, rel=1e-4, abs=1e-2 * np.abs(bend).max() * step_s + 1e-6)
    assert chirp.command(1.0 + 3 * SWEEP_S).u_h == pytest.approx(chirp.command(1.0).u_h)
    fine = np.array([chirp.command(t_s).u_h[0] for t_s in np.linspace(SWEEP_S - 0.1, SWEEP_S - 1e-6, 10_000)])
    crossings = np.count_nonzero(np.diff(np.sign(fine)))
    assert crossings == pytest.approx(2 * HIGHEST_HZ * 0.1, abs=1.5)  # r·0.1 s = 6 % lower at its beginning


def test_against_h_pushes_at_the_disk_in_sight() -> None:
    assert push(adversary("against-h"), (1.2, 0.0, -0.5, 0.0)) == pytest.approx((-STRENGTH, 0.0))
    assert push(adversary("against-h"), (1.0, 2.0, -0.5, 0.0)) == pytest.approx((-STRENGTH / 2, -STRENGTH))


def test_against_h_pushes_towards_the_tightest_row() -> None:
    """In a room of ±3 by ±2 with γ₁ = γ₂ = 10 at rest: ψ₂ = ±u + 100·distance, so 4 of u outweigh 4 cm."""
    source = adversary("against-h", "walls-and-disks")

    assert push(source, (2.90, -1.87, 0.0, 0.0)) == pytest.approx((STRENGTH, 0.0))
    assert push(source, (2.90, -1.87, 0.0, 0.0), u=(0.0, -4.0)) == pytest.approx((0.0, -STRENGTH))


def test_against_h_follows_what_moves_by_the_time_of_what_it_saw() -> None:
    """The visitor swings along the first axis with 1.5 m: at 1 s it is at +1.5, at 3 s at −1.5."""
    source = adversary("against-h", "moving-disk")

    assert push(source, (0.0, 0.0, 0.0, 0.0), plant_s=1.0)[0] == STRENGTH
    assert push(source, (0.0, 0.0, 0.0, 0.0), plant_s=3.0)[0] == -STRENGTH


def test_against_the_tank_pushes_along_the_velocity() -> None:
    """V = ‖x‖², y = x₂: ∇_u h_u = y − 2x₂ = −x₂, and the margin falls along x₂; at rest any way is as good."""
    source = adversary("against-the-tank")

    assert push(source, (2.0, 2.0, -0.5, 1.0)) == pytest.approx((-STRENGTH / 2, STRENGTH))
    assert push(source, (2.0, 2.0, 0.0, 0.0)) == (STRENGTH, 0.0)


def test_bang_bang_lets_go_and_pushes_the_other_way() -> None:
    source = adversary("bang-bang", seed=8)
    period_s = bang_bang_period_s(np.random.default_rng(8))
    assert 0.02 <= period_s <= 1.0

    assert push(source, (1.2, 0.0, -0.5, 0.0), t_s=0.0) == pytest.approx((-STRENGTH, 0.0))
    assert source.command(period_s / 2).u_h == pytest.approx((STRENGTH, 0.0))
    assert source.command(0.9 * period_s).u_h == pytest.approx((-STRENGTH, 0.0))


@pytest.mark.parametrize("strategy", ["against-h", "bang-bang", "against-the-tank"])
def test_who_has_seen_nothing_pushes_along_the_first_axis(strategy: str) -> None:
    assert adversary(strategy).command(0.0) == Command((STRENGTH, 0.0), (0.0, 0.0), True)


def test_barrier_without_input_effect_is_never_the_tightest() -> None:
    """A row −5 + ‖p‖² ≥ 0: at the origin it has no gradient and no input could help; the wall has one."""
    robot = damped_point()
    system, p = robot.system, robot.position
    gammas = (Linear(gain=1.0),) * 3
    dead = derive_chain(system, Barrier(name="dead", h=ca.sumsqr(p) - 5, class_k=gammas))
    wall = derive_chain(system, Barrier(name="wall", h=p[1] + 2, class_k=gammas))
    direction = ca.Function("f", [system.x, system.u, system.t], [against_h(system, [dead, wall])])

    assert direction([0, 0, 0, 0], [0, 0], 0).full().ravel().tolist() == [0.0, -1.0]
    assert ca.Function("g", [system.x], [against_h(system, [])])([0] * 4).full().ravel().tolist() == [1.0, 0.0]


def test_they_push_a_car_through_its_task_frame() -> None:
    """Into the post is a force in the picture, whatever the heading."""
    source = adversary("against-h", "unicycle-posts", strength=4.0)
    pushed = [push(source, (-1.5, 1.0, theta, 0.0, 0.0)) for theta in (0.0, 1.0, -2.0)]

    for (ahead, aside), theta in zip(pushed, (0.0, 1.0, -2.0), strict=True):
        nose = np.array([-1.5 + 0.3 * np.cos(theta), 1.0 + 0.3 * np.sin(theta)])
        towards = (np.array([0.0, 1.0]) - nose) / np.linalg.norm(np.array([0.0, 1.0]) - nose)
        assert np.array([ahead, aside]) @ towards > 0
