"""Adversary operators: the campaign's adversaries for the closed loop of nodes.

They use what an operator process can know: the newest state received and the model of the scenario.
"""

from typing import ClassVar

import casadi as ca
import numpy as np
from passafe_protocol.messages import PlantState, Vector

from passafe.barrier_chain import derive_chains
from passafe.numerics.workspace import BlockLayout, Workspace, dense_function
from passafe.passivity import power_margin
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.disturbances import Chirp, RandomSteps, bang_bang_period_s, bang_bang_sign
from passafe_services.operator.sources.source import CommandSource, SourceClock
from passafe_services.operator.sources.worst_direction import against_h, against_the_tank, through_task
from passafe_services.scenarios.design import barriers_of, robot_of, storage_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import AdversarySource


def adversary_of(config: AdversarySource, scenario: Scenario) -> CommandSource:
    """Return the adversary that ``config`` describes, for the scenario's robot.

    Raises:
        DesignError: The input has no effect on a barrier.
    """
    rng = np.random.default_rng(config.seed)
    robot = robot_of(scenario)
    system = robot.system
    if config.strategy == "piecewise-constant":
        return RandomSteps(rng, robot.commands, config.strength)
    if config.strategy == "chirp":
        return Chirp(rng, robot.commands, config.strength)
    if config.strategy == "against-the-tank":
        direction = against_the_tank(system, power_margin(system, storage_of(scenario, robot)))
    else:
        barriers = barriers_of(scenario, robot)
        direction = against_h(system, [chain for one in barriers for chain in derive_chains(system, one)])
    if robot.task is not None:
        direction = through_task(robot.task, direction)
    function = dense_function("push", [system.x, system.u, system.t], [config.strength * direction])
    period_s = bang_bang_period_s(rng) if config.strategy == "bang-bang" else None
    return AdversaryOperator(function, strength=config.strength, period_s=period_s)


class AdversaryOperator:
    """Pushes with full strength along a direction computed from the newest state, constantly or bang-bang.

    The direction is updated with every state; before the first one it is the first axis.
    """

    device: ClassVar[str] = "adversary"
    clock: ClassVar[SourceClock] = SourceClock.PLANT
    finished: ClassVar[bool] = False

    def __init__(self, push: ca.Function, *, strength: float, period_s: float | None) -> None:
        """Bind the function.

        Args:
            push: (x, u in force, t) → command, dense.
            strength: Largest |u_h|, units of u.
            period_s: Period of the bang-bang, s; ``None`` for a constant direction.
        """
        n, m, k = push.numel_in(0), push.numel_in(1), push.numel_out(0)
        self._space = Workspace(BlockLayout.of({"x": n, "u": m, "t": 1, "u_h": k}))
        self._evaluate = self._space.bind(push, ["x", "u", "t"], ["u_h"])
        self._write_x, self._write_u, self._write_t = (self._space.writer(name) for name in ("x", "u", "t"))
        self._read_u_h = self._space.reader("u_h")
        self._period_s = period_s
        self._rest: Vector = (0.0,) * k
        self._set_direction((strength, *self._rest[1:]))

    def observe(self, state: PlantState) -> None:
        """Update the direction for a state."""
        self._write_x(*state.x)
        self._write_u(*state.u)
        self._write_t(state.plant_ns / 1e9)
        self._evaluate()
        self._set_direction(self._read_u_h())

    def command(self, t_s: float) -> Command:
        """Return the command at plant time ``t_s`` ≥ 0."""
        if self._period_s is None or bang_bang_sign(t_s, self._period_s) > 0:
            return self._positive
        return self._negative

    def _set_direction(self, u_h: Vector) -> None:
        self._positive = Command(u_h, self._rest, True)
        self._negative = (
            self._positive if self._period_s is None else Command(tuple([-c for c in u_h]), self._rest, True)
        )
