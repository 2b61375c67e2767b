"""Runs in virtual time with random stops, deaths and outages, after each of which the robot is driven again."""

import random
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final, TypeGuard

import numpy as np
from passafe_protocol.messages import CommandState, FilterTick, Header, Message, PlantPhase, PlantState
from passafe_protocol.topics import Topic
from passafe_services.filter.build import filter_node
from passafe_services.loop.lockstep import START_NS, Lockstep
from passafe_services.operator.node import OperatorNode
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import SourceClock
from passafe_services.plant.build import plant_node
from passafe_services.scenarios.design import limits_of, robot_of
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import CompiledScenario, period_ns
from stop_console import StopConsole

RUN_S: Final = 12.0
STAMP: Final = 1e-4
"""u_h of a command per step of its session: it says when the command was made."""


class StampedSource:
    """Source whose commands say which step made them."""

    device = "stamped"
    clock = SourceClock.PLANT
    finished = False

    def __init__(self, strength: float) -> None:
        self._steps = 0
        self._strength = strength

    def command(self, t_s: float) -> Command:
        """Return a command of its own."""
        del t_s
        self._steps += 1
        return Command((self._steps * STAMP, self._strength), (0.0, 0.0), enabled=True)


@dataclass
class Record:
    """Record of what a run did.

    Attributes:
        states: Header time, ns, and state of the plant.
        ticks: Header time, ns, session and tick of the filter.
        begun: Time at which each session of the operator began, by epoch.
    """

    states: list[tuple[int, PlantState]] = field(default_factory=list)
    ticks: list[tuple[int, int, FilterTick]] = field(default_factory=list)
    begun: dict[int, int] = field(default_factory=dict)

    def __call__(self, _topic: Topic, header: Header, body: Message) -> None:
        """As an observer of a lockstep loop."""
        if isinstance(body, PlantState):
            self.states.append((header.scheduled_ns, body))
        elif isinstance(body, FilterTick):
            self.ticks.append((header.scheduled_ns, header.epoch, body))


def scenario_of(chance: random.Random) -> Scenario:
    """Return a robot with limits on the rate of its input, over random links."""
    rate = chance.choice([125.0, 250.0])
    links = {
        name: {
            "delay_s": chance.choice([0.01, 0.1, 0.4]) * chance.uniform(0.0, 1.0),
            "jitter_s": chance.uniform(0.0, 0.02),
            "loss": chance.choice([0.0, 0.1, 0.5]),
            "duplicate": chance.choice([0.0, 0.2]),
            "outages_s": [[begin, begin + chance.uniform(0.05, 1.5)] for begin in (chance.uniform(1.0, RUN_S),)],
            "seed": chance.randrange(2**31),
        }
        for name in ("operator-to-filter", "filter-to-plant", "plant-to-filter", "plant-to-operator")
    }
    return load_scenario(
        "notomista-cai-2020",
        {
            "rate_hz": rate,
            "plant.hold_s": chance.choice([1, 5]) / rate,
            "filter.input_rate_bound_per_s": chance.uniform(200.0, 800.0),
            "operator.stale_s": 1.0,
            "operator.resume_s": chance.uniform(0.01, 0.3),
            **{f"links.{name}": values for name, values in links.items()},
        },
    )


def run_of(seed: int) -> tuple[Scenario, Record]:
    """Return the scenario and the record of a run with everything random but its seed."""
    chance = random.Random(seed)
    scenario = scenario_of(chance)
    compiled, record = CompiledScenario.of(scenario), Record()
    epochs = random.Random(seed + 10**9)

    def operator(now_ns: int) -> tuple[OperatorNode, int]:
        epoch = epochs.randrange(1, 2**63)  # in no order
        record.begun[epoch] = now_ns
        return OperatorNode(StampedSource(chance.uniform(-9.0, 9.0)), epoch=epoch), epoch

    first, first_epoch = operator(START_NS)
    stops = [at_ns for k in range(5) for at_ns in _stop_and_clear(chance, 0.6 + 2.0 * k)]
    nodes = [
        plant_node(scenario, compiled.model),
        StopConsole(stops),
        first,
        filter_node(scenario, "lockstep", first_epoch, compiled.model, compiled.filter),
    ]
    loop = Lockstep(
        nodes, period_ns=period_ns(scenario), links=link_settings(scenario), epoch=first_epoch, observer=record
    )
    filter_epoch = first_epoch
    steps = round(RUN_S * scenario.rate_hz)
    deaths = sorted(chance.sample(range(steps // 4, steps * 3 // 4), 3))
    for begin, end in zip((0, *deaths), (*deaths, steps), strict=True):
        loop.run(end - begin)
        name = chance.choice(["operator", "filter"])
        loop.kill(name)
        loop.run(chance.randrange(1, steps // 10))
        if name == "operator":
            loop.restart(*operator(loop.now_ns))
        else:
            filter_epoch += 1
            again = filter_node(scenario, "lockstep", filter_epoch, compiled.model, compiled.filter)
            loop.restart(again, filter_epoch)
    loop.run(round(2.5 * scenario.rate_hz))
    return scenario, record


def _stop_and_clear(chance: random.Random, from_s: float) -> tuple[int, int]:
    """Return the times of a stop and its clear, ns: often so close that either is still on its way to the filter."""
    stop_s = from_s + chance.uniform(0.0, 0.8)
    clear_s = stop_s + chance.choice([0.02, 0.1, 0.3, 1.0]) * chance.uniform(0.5, 1.0)
    return START_NS + round(stop_s * 1e9), START_NS + round(clear_s * 1e9)


def resumes(record: Record) -> int:
    """Return how often an input took effect after a period without one."""
    phases = [state.phase for _, state in record.states]
    return sum(
        after is PlantPhase.RUNNING and before not in {PlantPhase.RUNNING, PlantPhase.WAITING}
        for before, after in pairwise(phases)
    )


def largest_rate_excess(scenario: Scenario, record: Record) -> float:
    """Return by how much an input in force was beyond the limits, those of the rates included, units of u."""
    limits, worst = limits_of(scenario, robot_of(scenario)), -np.inf
    for (_, before), (_, after) in pairwise(record.states):
        if after.phase is PlantPhase.RUNNING and after.plant_ns > before.plant_ns:
            step_s = (after.plant_ns - before.plant_ns) / 1e9
            worst = max(worst, float(limits.excess(np.array(after.u), np.array(before.u), step_s)))
    return worst


def inputs_in_spite_of_a_stop(record: Record) -> list[tuple[int, PlantState]]:
    """Return the states with a stop latched and an input of the filter in force."""
    return [
        (at, state)
        for at, state in record.states
        if state.stop and state.phase is not PlantPhase.FAIL_SAFE and state.phase is not PlantPhase.WAITING
    ]


def requests_before_they_may(record: Record) -> list[FilterTick]:
    """Return the decisions with a request of the operator although its command did not count, because of a stop."""
    decisions = _decisions(record).values()
    return [tick for tick in decisions if tick.command_state == CommandState.STOPPED and any(tick.u_h)]


def _decisions(record: Record) -> dict[tuple[int, int], FilterTick]:
    """Return each tick by session and number: the first, since a step without a decision repeats the one before."""
    return {(epoch, tick.tick): tick for _, epoch, tick in reversed(record.ticks)}


def _counts_in_full(tick: FilterTick | None) -> TypeGuard[FilterTick]:
    return tick is not None and tick.command_state == CommandState.COUNTS and tick.command_share == 1.0


def oldest_after_clear_ns(scenario: Scenario, record: Record) -> int | None:
    """Return the least time from a clear to the making of a command that moved the robot after it, ns.

    Below zero a command of before the clear moved it. A command in full tells by its u_h when it was made.
    """
    ticks = _decisions(record)
    found: list[int] = []
    clear_ns = cleared = 0
    for at_ns, state in record.states:
        if state.stops_cleared > cleared:
            clear_ns, cleared = at_ns, state.stops_cleared
        tick = ticks.get((state.input_epoch, state.applied_tick))
        if cleared and state.phase is PlantPhase.RUNNING and _counts_in_full(tick):
            begun_ns = max(begun for begun in record.begun.values() if begun <= at_ns)
            made_ns = begun_ns + (round(tick.u_h[0] / STAMP) - 1) * period_ns(scenario)
            found.append(made_ns - clear_ns)
    return min(found, default=None)
