"""The plant process as a node: the simulated robot, its play-out buffer and its own fail-safe."""

from collections.abc import Sequence
from math import hypot, inf
from struct import Struct
from typing import Final

import casadi as ca

from passafe.limits import Limits
from passafe.models.robot import Robot
from passafe.sampled_plant import SampledPlant
from passafe.workspace import Layout, Workspace, dense_function
from protocol.messages import Event, PlantInput, PlantPhase, PlantState, Received, Vector
from protocol.topics import EVENT, INPUT, STATE, Topic
from services.plant.playout import PlayoutBuffer
from services.runtime.node import Outgoing

ROUNDING: Final = 1e-12
"""By how much an input shortened to its norm's limit may still be longer, relative."""

# Members by name: reaching one through its enumeration takes 0.7 µs on Python 3.11.
WAITING, RUNNING, HOLDING, FAIL_SAFE = PlantPhase


class PlantNode:
    """Integrates the robot, one period a step, under the inputs of the filter.

    Until the first input arrives the robot rests at x0 (``WAITING``). That input takes effect ``playout`` later
    than it arrived, which sets plant time; every other takes effect at the plant time it names. When one is
    missing the last is held (``HOLDING``); held for longer than the input allows, or than the plant allows, the
    model's own law takes over (``FAIL_SAFE``) until an input is due again.

    A driver that skipped steps gets one state for every period that passed: time does not stop for a robot.

    Attributes:
        name: ``plant``.
        subscribes: Inputs of the filter.
        plant_ns: Plant time, ns.
    """

    name = "plant"
    subscribes: tuple[Topic, ...] = (INPUT,)

    def __init__(
        self,
        robot: Robot,
        plant: SampledPlant,
        *,
        x0: Sequence[float],
        period_ns: int,
        playout_ns: int,
        hold_ns: int,
        limits: Limits,
    ) -> None:
        """Put the robot at rest at x0.

        Args:
            robot: The model and its fail-safe law.
            plant: The same model, stepped with the same period.
            x0: Initial state, n numbers.
            period_ns: Period of a step, ns.
            playout_ns: How long before its effect the first input should have arrived, ns.
            hold_ns: Longest time for which any input may be held, ns.
            limits: Inputs beyond their magnitudes or their norm are refused; how fast u changes is not looked at.
        """
        m = robot.system.m
        self._plant = plant
        self._fail_safe = _BoundedLaw(robot, limits)
        self._sample = plant.at(x0)
        self._period_ns = period_ns
        self._playout_ns = playout_ns
        self._hold_ns = hold_ns
        self._m, self._bounds, self._least_bound = m, limits.magnitude, min(limits.magnitude)
        self._norm = inf if limits.norm is None else limits.norm * (1 + ROUNDING)
        self._buffer = PlayoutBuffer(period_ns)
        self._origin_ns: int | None = None
        self.plant_ns = 0
        self._in_force: PlantInput | None = None
        self._u: Vector = (0.0,) * m
        self._phase = WAITING
        self._energy_in_j = 0.0
        self._slack_ns = 0
        self._late = 0
        self._refused = 0

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the state now, and those of every period that passed since the step before.

        Args:
            now_ns: Monotonic time of this step, ns.
            inbox: Inputs, in order of arrival.
        """
        for received in inbox:
            if type(received.body) is PlantInput:
                self._receive(received.body, received.received_ns)
        if self._origin_ns is None or now_ns < self._origin_ns + self.plant_ns:
            return ((STATE, self._state()),)
        outgoing = []
        if self._phase is WAITING:
            outgoing += self._choose_input()
            outgoing.append((STATE, self._state()))
        while self._origin_ns + self.plant_ns + self._period_ns <= now_ns:
            self._sample = self._plant.advance(self._sample.x, self._u)
            self._energy_in_j += self._sample.energy_in_j
            self.plant_ns += self._period_ns
            outgoing += self._choose_input()
            outgoing.append((STATE, self._state()))
        return outgoing or ((STATE, self._state()),)

    def _receive(self, plant_input: PlantInput, received_ns: int) -> None:
        if not self._is_applicable(plant_input.u) or not self._buffer.put(plant_input):
            self._refused += 1
            return
        due_ns = plant_input.effective_plant_ns
        if self._origin_ns is None:
            self.plant_ns = due_ns
            # Steps come on a grid: the first one after the buffer has filled is plant time `due_ns`.
            self._origin_ns = received_ns + self._playout_ns - due_ns
        if self._phase is not WAITING and due_ns <= self.plant_ns:
            self._late += 1
        self._slack_ns = due_ns - (received_ns - self._origin_ns)

    def _is_applicable(self, u: Vector) -> bool:
        """Tell whether an input has the plant's shape and lies within the limits; a NaN does not."""
        if len(u) != self._m:
            return False
        least = self._least_bound
        for value in u:
            if not -least <= value <= least:
                return all(-bound <= value <= bound for value, bound in zip(u, self._bounds, strict=True)) and (
                    hypot(*u) <= self._norm
                )
        return self._norm == inf or hypot(*u) <= self._norm

    def _choose_input(self) -> list[Outgoing]:
        """Decide what is in force from the present plant time on; return an event when that changes in kind."""
        before = self._phase
        due = self._buffer.take(self.plant_ns)
        if due is not None and (self._in_force is None or due.tick > self._in_force.tick):
            self._in_force, self._u, self._phase = due, due.u, RUNNING
        elif self._in_force is not None:
            held_ns = self.plant_ns - self._in_force.effective_plant_ns
            if held_ns > self._hold_ns or held_ns > self._in_force.hold_ns:
                self._phase = FAIL_SAFE
            elif self._phase is not FAIL_SAFE:
                self._phase = HOLDING
        if self._phase is FAIL_SAFE:
            self._u = self._fail_safe(self._sample.x)
        return [] if self._phase is before else self._announce(before)

    def _announce(self, before: PlantPhase) -> list[Outgoing]:
        if before is not FAIL_SAFE and self._phase is not FAIL_SAFE:
            return []
        at = f"plant time {self.plant_ns / 1e9:.3f} s"
        if self._phase is FAIL_SAFE:
            return [(EVENT, Event("warning", f"inputs stopped: fail-safe law in force at {at}"))]
        return [(EVENT, Event("info", f"inputs are back: fail-safe law released at {at}"))]

    def _state(self) -> PlantState:
        sample, in_force = self._sample, self._in_force
        return PlantState(
            self.plant_ns,
            sample.x,
            sample.y,
            self._u,
            0 if in_force is None else in_force.tick,
            self._phase,
            self._energy_in_j,
            sample.stored_j,
            self._slack_ns,
            self._late,
            self._refused,
            sample.integration_error,
            self._buffer.received_tick,
        )


class _BoundedLaw:
    """The robot's fail-safe law, clipped to the limits of the input."""

    def __init__(self, robot: Robot, limits: Limits) -> None:
        system = robot.system
        self._space = Workspace(Layout.of({"x": system.n, "u": system.m}))
        bound = ca.DM(list(limits.magnitude))
        clipped = limits.clip(robot.fail_safe, ca.DM.zeros(system.m), -bound, bound)
        self._evaluate = self._space.bind(dense_function("fail_safe", [system.x], [clipped]), ["x"], ["u"])
        self._give = Struct(f"{system.m}d").unpack_from
        self._offset = system.n * 8

    def __call__(self, x: Vector) -> Vector:
        self._space.part("x")[:] = x
        self._evaluate()
        return self._give(self._space.memory, self._offset)
