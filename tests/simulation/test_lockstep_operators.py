"""Operators who close the loop, in lockstep: delay destabilises what is not protected and harms nothing that is."""

from typing import NamedTuple

import numpy as np
import pytest
from passafe_protocol.messages import Header, Message, PlantPhase, PlantState
from passafe_protocol.topics import Topic
from passafe_services.operator.sources.scenario_source import crossover_loop
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.review.core_evaluator import CoreEvaluator

LINK = "operator-to-filter"


class Run(NamedTuple):
    """States of a run, a column each, and their smallest barrier value."""

    t_s: np.ndarray
    x: np.ndarray
    h_min: float


def run_of(name: str, **overrides: object) -> Run:
    scenario = load_scenario(name, {key.replace("__", "."): value for key, value in overrides.items()})
    states: list[PlantState] = []

    def keep(_topic: Topic, _header: Header, body: Message) -> None:
        if isinstance(body, PlantState) and body.phase is not PlantPhase.WAITING:
            states.append(body)

    lockstep_loop(scenario, observer=keep).run(steps_of(scenario))
    t_s = np.array([state.plant_ns / 1e9 for state in states])
    x = np.array([state.x for state in states]).T
    return Run(t_s, x, float(CoreEvaluator(scenario).h(x, t_s).min()))


def late(delay_s: float) -> dict[str, object]:
    return {LINK: {"delay_s": delay_s}}


def test_a_person_with_little_delay_needs_no_filter() -> None:
    run = run_of("human-steers", filter__mode="off", links=late(0.05))
    source = load_scenario("human-steers").operator.source
    assert isinstance(source, HumanSource)

    assert run.h_min > 0
    for target, until_s in zip(source.targets, (6.0, 12.0, 18.0), strict=True):
        settled = (run.t_s > until_s - 1.0) & (run.t_s < until_s)
        away = np.linalg.norm(run.x[:2, settled] - np.array([target.position]).T, axis=0)
        assert away.max() < source.tolerance_m


@pytest.mark.parametrize(("share", "grows"), [(0.97, False), (1.03, True)])
def test_unfiltered_loop_diverges_at_the_predicted_delay_margin(share: float, grows: bool) -> None:
    """Little of the margin goes to the loop itself: play-out and two ticks, 15 ms at 200 Hz."""
    source = {
        "kind": "human",
        "targets": [{"at_s": 0.0, "position": [2.2, -0.9]}],
        "crossover_rad_per_s": 1.5,
        "authority": 1e4,
        "remnant": 0.0,
    }
    margin_s = crossover_loop(HumanSource.model_validate(source)).delay_margin_s
    run = run_of(
        "human-steers",
        filter__mode="off",
        filter__input_bound=1e5,
        operator__source=source,
        rate_hz=200.0,
        duration_s=60.0,
        links=late(share * (margin_s - 0.015)),
    )
    away = np.linalg.norm(run.x[:2] - np.array([[2.2], [-0.9]]), axis=0)
    fifth = len(away) // 5

    assert bool(away[-fifth:].max() > away[-2 * fifth : -fifth].max()) is grows


@pytest.mark.parametrize("delay_s", [0.4, 1.0])
def test_filter_keeps_delayed_commands_from_the_walls(delay_s: float) -> None:
    assert run_of("human-steers", filter__mode="off", links=late(delay_s), duration_s=8.0).h_min < -0.5
    assert run_of("human-steers", filter__mode="both", links=late(delay_s), duration_s=8.0).h_min >= 0


@pytest.mark.parametrize("strategy", ["piecewise-constant", "chirp", "bang-bang", "against-h", "against-the-tank"])
def test_adversaries_as_operators_do_not_break_what_is_protected(strategy: str) -> None:
    source = {"kind": "adversary", "strategy": strategy, "seed": 2}

    assert run_of("walls-and-disks", operator__source=source, duration_s=4.0).h_min >= 0


def test_the_adversary_against_h_breaks_what_is_not_protected() -> None:
    source = {"kind": "adversary", "strategy": "against-h"}

    assert run_of("walls-and-disks", operator__source=source, duration_s=4.0, filter__mode="off").h_min < -0.1


def test_two_runs_of_a_person_are_the_same() -> None:
    first, second = (run_of("human-steers", duration_s=2.0, links=late(0.1)) for _ in range(2))

    assert np.array_equal(first.x, second.x)
