import casadi as ca
from closed_form import paper_scenario
from hypothesis import given
from hypothesis import strategies as st

from dashboard.obstacles import Disk, HalfPlane, obstacles_of, unit_of_h
from passafe.shapes import disk_keep_out, half_plane
from services.scenarios.schema import Scenario

numbers = st.floats(-100, 100)
points = st.tuples(numbers, numbers)


@given(points, points, st.floats(0.01, 50))
def test_disk_is_the_core_s_barrier(position: tuple[float, float], centre: tuple[float, float], radius: float) -> None:
    p = ca.SX.sym("p", 2)
    core = ca.Function("h", [p], [disk_keep_out(p, centre=centre, radius=radius)])
    shape = Disk(name="a", centre=centre, radius=radius)
    assert abs(shape.h((*position, 7.0, 7.0)) - float(core(position))) <= 1e-9 * (1 + abs(shape.h(position)))


@given(points, points.filter(any), numbers)
def test_half_plane_is_the_core_s_barrier(
    position: tuple[float, float], normal: tuple[float, float], offset: float
) -> None:
    p = ca.SX.sym("p", 2)
    core = ca.Function("h", [p], [half_plane(p, normal=normal, offset=offset)])
    shape = HalfPlane(name="a", normal=normal, offset=offset)
    assert abs(shape.h((*position, 7.0)) - float(core(position))) <= 1e-9 * (1 + abs(shape.h(position)))


def test_shapes_keep_the_scenario_s_order() -> None:
    values = paper_scenario().model_dump()
    wall = {"kind": "half-plane", "name": "wall", "normal": (0.0, 1.0), "offset": -3.0}
    disk = values["filter"]["barriers"][0]
    values["filter"]["barriers"] = [wall | {"class_k": disk["class_k"]}, disk]
    shapes = obstacles_of(Scenario.model_validate(values))
    assert shapes == (
        HalfPlane(name="wall", normal=(0.0, 1.0), offset=-3.0),
        Disk(name="disk", centre=(0.0, 0.0), radius=1.0),
    )
    assert [unit_of_h(shape) for shape in shapes] == ["m", "m²"]
