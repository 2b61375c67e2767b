"""Shapes say of what kind each field is and where it stands."""

from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of
from passafe_protocol.messages import (
    BarrierReport,
    Certificate,
    FilterStatus,
    FilterTick,
    LinkConfig,
    OverrideReport,
    PlantPhase,
    PlantState,
    RowReport,
)
from passafe_protocol.shapes import as_dict, shape_of


def test_plant_state_is_read_from_its_annotations() -> None:
    shape = shape_of(PlantState)

    assert [name for _, name in shape.vectors] == ["x", "y", "u", "u_asked", "true_x"]
    assert [name for _, name in shape.floats] == ["energy_in_j", "energy_stored_j", "integration_error"]
    assert [(name, members) for _, name, members in shape.enums] == [
        ("phase", {member.value: member for member in PlantPhase})
    ]
    assert {name for _, name in (*shape.plain, *shape.vectors)} == set(shape.names)
    assert not shape.parts
    assert not shape.lists


def test_parts_and_lists_carry_the_shapes_within() -> None:
    shape = shape_of(FilterTick)

    assert [(name, part.record_type) for _, name, part in shape.parts] == [
        ("certificate", Certificate),
        ("override", OverrideReport),
    ]
    assert [(name, part.record_type) for _, name, part in shape.lists[:2]] == [
        ("barriers", BarrierReport),
        ("rows", RowReport),
    ]
    assert shape.enums[0][2][FilterStatus.STALE.value] is FilterStatus.STALE


def test_every_entry_has_its_index() -> None:
    shape = shape_of(FilterTick)
    kinds = (shape.plain, shape.floats, shape.enums, shape.vectors, shape.parts, shape.lists)

    assert all(shape.names[entry[0]] == entry[1] for kind in kinds for entry in kind)


def test_make_undoes_read() -> None:
    row = RowReport("disk", 0.5, 0.25, active=True)
    shape = shape_of(RowReport)

    made = shape.make(*shape.read(row))

    assert made == row
    assert type(made) is RowReport


def test_records_within_a_record_become_dictionaries_too() -> None:
    settings = LinkSettings(delay_s=0.1, outages_s=((1.0, 2.0), (3.0, 4.0)))

    given = as_dict(LinkConfig("plant-to-filter", parameters_of(settings)))

    assert list(given) == ["link", "parameters"]
    assert list(given["parameters"]) == list(shape_of(type(parameters_of(settings))).names)
    assert given["parameters"]["delay_s"] == 0.1
    assert given["parameters"]["outages"] == [{"start_s": 1.0, "end_s": 2.0}, {"start_s": 3.0, "end_s": 4.0}]
