"""Simulation of a scenario's closed loop in virtual time: the same nodes as live, in one process."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Self

from passafe_protocol.topics import Topic

from passafe_services.filter.build import CompiledFilter, filter_node
from passafe_services.loop.lockstep import Lockstep, Observer, Tap
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import PlantModel, period_ns
from passafe_services.scenarios.links import link_changes, link_settings
from passafe_services.scenarios.schema import Scenario

VIRTUAL_WALL_NS: Final = 1_000_000_000_000_000_000
"""Wall clock minus virtual clock of a lockstep run: a fixed day in 2001, so that logs show it and stay the same."""


@dataclass(frozen=True, kw_only=True)
class CompiledScenario:
    """Parts of a scenario's plant and filter that are expensive to build and have no state.

    Loops that run one after the other may share it, whatever their links, initial states, operators and durations, if
    ``key_of`` is the same for their scenarios.

    Attributes:
        model: Model of the plant.
        filter: The filter.
    """

    model: PlantModel
    filter: CompiledFilter

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Compile both.

        Raises:
            ScenarioError: The parameters or x0 do not fit the model.
            DesignError: A part of the design is not valid.
        """
        model = PlantModel.of(scenario)
        return cls(model=model, filter=CompiledFilter.of(scenario, model.robot))

    @staticmethod
    def key_of(scenario: Scenario) -> str:
        """Return the part of a scenario that is compiled, as text."""
        plant = {"model", "parameters", "robot", "hold_s", "playout_s", "guard"}
        whole = dict.fromkeys(("name", "rate_hz", "filter", "uncertainty"), True)
        part = scenario.model_dump_json(include={**whole, "plant": plant})
        return f"{len(scenario.plant.x0)} {part}"


def steps_of(scenario: Scenario) -> int:
    """Return the number of lockstep steps for the scenario's duration in plant time, without delay."""
    return round(scenario.duration_s * scenario.rate_hz) + round(scenario.plant.playout_s * scenario.rate_hz) + 1


def lockstep_loop(
    scenario: Scenario,
    observer: Observer | None = None,
    *,
    taps: Mapping[Topic, Tap] | None = None,
    compiled: CompiledScenario | None = None,
) -> Lockstep:
    """Return the closed loop of a scenario in virtual time.

    Args:
        scenario: The scenario.
        observer: Called with every message, see ``Lockstep``.
        taps: Called with the outgoing items of the nodes, by topic, see ``Lockstep``.
        compiled: Compiled scenario, if there is one already; no other loop may be using it.
    """
    epoch = 1
    compiled = CompiledScenario.of(scenario) if compiled is None else compiled
    return Lockstep(
        [
            plant_node(scenario, compiled.model),
            operator_node(scenario, epoch),
            filter_node(scenario, "lockstep", epoch, compiled.model, compiled.filter),
        ],
        period_ns=period_ns(scenario),
        links=link_settings(scenario),
        link_changes=link_changes(scenario),
        wall_offset_ns=VIRTUAL_WALL_NS,
        epoch=epoch,
        observer=observer,
        taps=taps,
    )
