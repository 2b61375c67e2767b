import math

import pytest
from passafe_protocol.messages import FilterTick, LinkState
from passafe_protocol.topics import HEALTH, INPUT, LINK_STATE, STATE, TICK, TOPICS, Topic
from passafe_services.scenarios.load import load_scenario, shipped_scenarios
from passafe_services.tables.columns import Column
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.units import units_of
from small_log import LARGE, PERIOD_NS, WALL_NS, header, health, state, tick


def row_of(layout: TableLayout, k: int, body: FilterTick) -> dict[str, object]:
    values = layout.row(WALL_NS + k * PERIOD_NS, WALL_NS, header("filter", k), body)
    return dict(zip([column.name for column in layout.columns], values, strict=True))


def test_vectors_and_named_parts_become_columns_of_their_own() -> None:
    layout = TableLayout(TICK)
    layout.note(tick(3))

    row = row_of(layout, 3, tick(3))

    assert row["plant_s"] == pytest.approx(0.003)
    assert row["time_s"] == pytest.approx(0.003)
    assert [row[f"x_hat_{k}"] for k in range(1, 5)] == [1.0, 2.0, 3.0, 4.0]
    assert [row[f"barrier_disk_psi_{k}"] for k in range(3)] == [3.5, 2.0, 3.0]
    assert (row["row_disk_margin"], row["row_passivity_active"]) == (0.75, True)
    assert (row["status"], row["certificate_solver"], row["header_epoch"]) == ("MODIFIED", "piqp", LARGE)


def test_layout_grows_with_what_a_message_has() -> None:
    layout = TableLayout(TICK)

    assert layout.note(tick(0, rows=()))
    before = layout.columns
    assert not layout.note(tick(1, rows=()))
    assert layout.note(tick(2))

    added = set(layout.columns) - set(before)
    assert {column.name for column in added} == {
        f"row_{name}_{field}"
        for name in ("disk", "passivity")
        for field in ("margin", "dual", "active", "share", "relaxed")
    }


def test_numbers_that_a_message_lacks_are_not_a_number() -> None:
    layout = TableLayout(TICK)
    layout.note(tick(1))

    row = row_of(layout, 0, tick(0, rows=(), barriers=()))

    assert all(math.isnan(float(str(row[name]))) for name in ("barrier_disk_psi_0", "row_disk_margin"))


def test_health_has_the_counts_of_each_topic_by_name() -> None:
    layout = TableLayout(HEALTH)
    layout.note(health("state", "link_event"))

    names = [column.name for column in layout.columns]

    assert {"topic_state_received", "topic_link_event_gaps"} <= set(names)


def test_names_that_differ_in_a_dash_alone_stay_apart() -> None:
    layout = TableLayout(TICK)
    layout.note(tick(0, barriers=("left-wall", "left_wall", "Ψ")))

    names = [column.name for column in layout.columns]

    assert len(set(names)) == len(names)
    assert {"barrier_left_wall_eps", "barrier_left_wall_eps__2", "barrier_unnamed_eps"} <= set(names)


def test_repeated_inputs_are_counted_and_not_spread_over_columns() -> None:
    names = [column.name for column in TableLayout(INPUT).columns]

    assert "previous_u_count" in names


def test_kinds_are_those_of_the_wire() -> None:
    kinds = {column.name: column.kind for column in TableLayout(STATE).columns}

    assert kinds["plant_ns"] == "int"
    assert kinds["input_epoch"] == "uint"
    assert kinds["phase"] == "text"
    assert kinds["energy_in_j"] == "float"


@pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)
def test_every_topic_has_a_table_with_plain_names(topic: Topic) -> None:
    columns = TableLayout(topic).columns

    assert all(column.name.isidentifier() and column.name == column.name.lower() for column in columns)
    assert columns[0] == Column("time_s", "float", "s")


def test_units_are_those_of_the_scenario() -> None:
    layout, other = TableLayout(STATE), TableLayout(TICK)
    scenario = load_scenario("notomista-cai-2020")
    for one in (layout, other):
        one.name_units(units_of(scenario))
    layout.note(state(0))
    other.note(tick(0))
    units = {column.name: column.unit for column in (*layout.columns, *other.columns)}

    assert [units[f"x_{k}"] for k in range(1, 5)] == ["m", "m", "m/s", "m/s"]
    assert (units["u_1"], units["u_h_1"], units["energy_in_j"]) == ("m/s²", "m/s²", "J")
    assert [units[f"barrier_disk_psi_{k}"] for k in range(3)] == ["m²", "m²/s", "m²/s²"]
    assert (units["power_margin"], units["row_disk_margin"], units["row_disk_dual"]) == ("W", "m/s²", "")


@pytest.mark.parametrize("name", shipped_scenarios())
def test_every_shipped_scenario_has_units(name: str) -> None:
    scenario = load_scenario(name)
    units = units_of(scenario)

    assert all(units[f"x_{k}"] for k in range(1, len(scenario.plant.x0) + 1))
    for barrier in scenario.barriers:
        assert units[f"barrier {barrier.name} psi_0"] == barrier.h_unit


def test_speed_limits_have_seconds_counted_on() -> None:
    units = units_of(load_scenario("walls-and-disks"))
    rates = {unit for name, unit in units.items() if name.endswith("psi_1")}

    assert all(unit.count("/") == 1 for unit in rates)


def test_unknown_units_stay_empty() -> None:
    assert units_of(None) == {}
    assert [column.unit for column in TableLayout(LINK_STATE).columns if column.name == "link"] == [""]
    assert LinkState is LINK_STATE.body


def test_headings_carry_each_unit_once() -> None:
    assert Column("x_1", "float", "m").heading == "x_1 [m]"
    assert Column("sent_ns", "int", "ns").heading == "sent_ns"
    assert Column("status", "text").heading == "status"


def test_units_of_a_robots_states_are_its_own() -> None:
    units = units_of(load_scenario("unicycle-posts"))

    assert [units[f"x_{k}"] for k in range(1, 6)] == ["m", "m", "rad", "m/s", "rad/s"]
