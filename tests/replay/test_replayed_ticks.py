"""Columns of replayed ticks beside the messages that the filter publishes of the same ticks."""

from collections.abc import Sequence

import pytest
from msgspec.structs import replace
from passafe_protocol.messages import Header, Received
from passafe_protocol.topics import TICK
from passafe_services.filter.build import CompiledFilter, filter_node
from passafe_services.filter.telemetry import TickRecord
from passafe_services.log.column import same_rows
from passafe_services.log.message_columns import columns_of
from passafe_services.log.message_field import fields_of
from passafe_services.loop.lockstep import Lockstep
from passafe_services.node import Node, Outgoing
from passafe_services.operator.build import operator_node
from passafe_services.plant.build import plant_node
from passafe_services.plant_contract.plant_model import PlantModel, period_ns
from passafe_services.scenarios.links import link_settings
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.replay.replayed_ticks import ReplayedTicks

BODY_FIELDS = [path for path in fields_of(TICK) if not path.startswith("header.")]
LATE = {"links.plant-to-filter": {"delay_s": 0.02, "jitter_s": 0.02, "loss": 0.2, "seed": 1}}


class Recorded:
    """Filter whose tick records are kept.

    Attributes:
        name: The filter's.
        subscribes: The filter's.
        records: Its tick records so far.
    """

    def __init__(self, node: Node) -> None:
        self.name, self.subscribes = node.name, node.subscribes
        self.records: list[TickRecord] = []
        self._node = node

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        outgoing = self._node.step(now_ns, inbox)
        self.records += [body for _, body in outgoing if isinstance(body, TickRecord)]
        return outgoing


def ticks_of(name: str, **overrides: object) -> tuple[CompiledFilter, list[TickRecord]]:
    scenario = load_scenario(name, {"rate_hz": 250.0, **overrides})
    model = PlantModel.of(scenario)
    compiled = CompiledFilter.of(scenario, model.robot)
    recorded = Recorded(filter_node(scenario, "lockstep", 1, model, compiled))
    nodes = [plant_node(scenario, model), operator_node(scenario, 1), recorded]
    Lockstep(nodes, period_ns=period_ns(scenario), links=link_settings(scenario)).run(200)
    return compiled, recorded.records


@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("notomista-cai-2020", {}),
        ("notomista-cai-2020", LATE),
        ("notomista-cai-2020", {"filter.mode": "off"}),
        ("notomista-cai-2020", {"filter.law": "continuous"}),
        ("walls-and-disks", {}),
        ("tight-limits", LATE),
        ("two-robots", {}),
        ("lagged-point", {}),
        ("unicycle-posts", {}),
        ("wrong-mass", {}),
    ],
)
def test_columns_are_those_of_the_messages(name: str, overrides: dict[str, object]) -> None:
    compiled, records = ticks_of(name, **overrides)
    header = Header("filter", 1, 0, 0, 0, 0, 0)
    messages = [(replace(header, sequence=k), record()) for k, record in enumerate(records)]

    found = ReplayedTicks(compiled).columns(records)

    expected = columns_of(TICK, messages, BODY_FIELDS)
    assert set(found) == set(expected)
    for path, column in expected.items():
        assert same_rows(column, found[path]).all(), path
