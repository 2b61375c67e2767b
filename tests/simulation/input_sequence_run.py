"""A closed loop in lockstep whose processes can be killed and whose links can be cut, and what must hold of it."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np
from passafe_protocol.codec import encode
from passafe_protocol.messages import (
    FilterTick,
    Header,
    Message,
    OperatorCommand,
    PlantInput,
    PlantPhase,
    PlantState,
    Received,
)
from passafe_protocol.topics import Topic
from passafe_services.filter.build import filter_node
from passafe_services.loop.lockstep import Lockstep, Observer
from passafe_services.node import Node, Outgoing
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import period_ns
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import VIRTUAL_WALL_NS
from passafe_services.tools.review.core_evaluator import CoreEvaluator

INPUTS, STATES, COMMANDS = PlantInput, PlantState, OperatorCommand

RATE_HZ = 200.0
"""Of most of these runs: a fifth of the paper's, so that many fit in a second."""

SLOW = {"rate_hz": RATE_HZ, "filter.k_i": 50.0, "plant.hold_s": 0.01}


class Cut:
    """A node at the end of a link that can be cut: while ``severed`` holds a type of message, none of it arrives."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.name, self.subscribes = node.name, node.subscribes
        self.severed: set[type[Message]] = set()

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        return self.node.step(now_ns, [each for each in inbox if type(each.body) not in self.severed])


class InputSequenceRun:
    """The loop of a scenario and everything that was sent in it."""

    def __init__(
        self, name: str = "notomista-cai-2020", *, observer: Observer | None = None, **overrides: object
    ) -> None:
        values = SLOW | {key.replace("__", "."): value for key, value in overrides.items()}
        self.scenario: Scenario = load_scenario(name, values)
        self.sent: list[tuple[Topic, Header, Message]] = []
        self._observer = observer
        self.plant, self.filter = Cut(plant_node(self.scenario)), Cut(filter_node(self.scenario, "lockstep", 1))
        self.epoch = 1
        self.loop = Lockstep(
            [self.plant, operator_node(self.scenario, 1), self.filter],
            period_ns=period_ns(self.scenario),
            links=link_settings(self.scenario),
            wall_offset_ns=VIRTUAL_WALL_NS,
            observer=self._observe,
        )

    def run(self, seconds: float) -> "InputSequenceRun":
        """Advance."""
        self.loop.run(round(seconds * self.scenario.rate_hz))
        return self

    def restart_filter(self, dead_s: float = 0.0) -> None:
        """Kill the filter and start another one after a while."""
        self.loop.kill("filter")
        self.run(dead_s)
        self.epoch += 1
        self.filter = Cut(filter_node(self.scenario, "lockstep", self.epoch))
        self.loop.restart(self.filter, self.epoch)

    def restart_plant(self) -> None:
        """Kill the plant and start another one at once."""
        self.epoch += 1
        self.plant = Cut(plant_node(self.scenario))
        self.loop.restart(self.plant, self.epoch)

    @property
    def state(self) -> PlantState:
        """Newest state of the plant."""
        return next(body for _, _, body in reversed(self.sent) if isinstance(body, PlantState))

    @property
    def in_sequence(self) -> bool:
        """True while the plant applies an input of a sequence."""
        return self.state.phase is PlantPhase.RUNNING

    def seconds_until_sequence(self, at_most_s: float) -> float:
        """Return how long the loop runs until the plant follows an input sequence; infinity beyond ``at_most_s``."""
        for steps in range(round(at_most_s * self.scenario.rate_hz) + 1):
            if self.in_sequence:
                return steps / self.scenario.rate_hz
            self.loop.run(1)
        return float("inf")

    def ticks(self) -> list[FilterTick]:
        """Every account of the filter."""
        return [body for _, _, body in self.sent if isinstance(body, FilterTick)]

    def trajectory(self) -> list[PlantState]:
        """Return the plant's states from its first input on, one per plant time."""
        moving: dict[int, PlantState] = {}
        for _, _, body in self.sent:
            if isinstance(body, PlantState) and body.phase is not PlantPhase.WAITING:
                moving.setdefault(body.plant_ns, body)
        return list(moving.values())

    def sequence_breaks(self) -> list[int]:
        """Plant times at which an input was missing."""
        return sorted({state.sequence_break_ns for state in self.trajectory()} - {-1})

    def wire(self) -> list[bytes]:
        """Everything as bytes."""
        return [encode(header, body) for _, header, body in self.sent]

    def inexact(self) -> tuple[int, list[int]]:
        """Return how many inputs took effect, and the plant times of those decided for another state than they met."""
        decided: dict[tuple[int, int], list[FilterTick]] = defaultdict(list)
        for tick in self.ticks():
            decided[tick.effective_plant_ns, tick.tick].append(tick)
        running = [state for state in self.trajectory() if state.phase is PlantPhase.RUNNING]
        wrong = [
            state.plant_ns
            for state in running
            if not any(
                tick.x_hat == state.x and tick.u == state.u for tick in decided[state.plant_ns, state.applied_tick]
            )
        ]
        return len(running), wrong

    def least_h(self, parts: int = 4) -> float:
        """Return the smallest barrier value at the samples and between them."""
        mathematics, states = CoreEvaluator(self.scenario), self.trajectory()
        x, u = np.array([state.x for state in states]).T, np.array([state.u for state in states]).T
        t_s = np.array([state.plant_ns for state in states]) * 1e-9
        dt_s = self.scenario.dt_s
        values = [mathematics.h(x, t_s).min()]
        for part in range(1, parts):
            after_s = dt_s * part / parts
            values.append(mathematics.h(mathematics.flow(x, u, after_s), t_s + after_s).min())
        return float(min(values))

    def _observe(self, topic: Topic, header: Header, body: Message) -> None:
        self.sent.append((topic, header, body))
        if self._observer is not None:
            self._observer(topic, header, body)


def bad_links(*names: str, **settings: float) -> dict[str, object]:
    """Return overrides that give links the same settings, all of them if none is named."""
    everyone = names or ("operator-to-filter", "filter-to-plant", "plant-to-filter")
    return {f"links.{name}": settings for name in everyone}
