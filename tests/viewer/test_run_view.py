import math

import pytest
from foxglove_schemas_protobuf.Log_pb2 import Log
from msgspec.structs import replace
from own_robots import on_three_cables, scenario_of, two_tanks
from passafe_protocol.messages import (
    BarrierReport,
    EmergencyStop,
    Event,
    Message,
    OperatorCommand,
    PlantState,
    StopClear,
)
from passafe_protocol.topics import TOPIC_OF_BODY, TOPICS
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.scenarios.load import load_scenario
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.log_messages import LoggedRow
from passafe_services.viewer.log_lines import log_line
from passafe_services.viewer.named_numbers import NamedNumbers
from passafe_services.viewer.run_view import RunView
from passafe_services.viewer.scene import BARRIERS, JOINTS, POSES, ROBOT, TRANSFORMS, Scene
from passafe_services.viewer.view_message import ViewMessage
from small_log import PERIOD_NS, WALL_NS, header, state, tick


def logged(source: str, k: int, body: Message) -> LoggedRow:
    topic = TOPIC_OF_BODY[type(body)]
    return LoggedRow(topic, topic.key(source), WALL_NS + k * PERIOD_NS, header(source, k), body, b"")


def run_view(scenario: str = "notomista-cai-2020") -> tuple[RunView, dict[str, TableLayout]]:
    layouts = {topic.name: TableLayout(topic) for topic in TOPICS}
    return RunView(load_scenario(scenario), layouts, WALL_NS), layouts


def shown(view: RunView, layouts: dict[str, TableLayout], row: LoggedRow) -> dict[str, ViewMessage]:
    layouts[row.topic.name].note(row.body)
    return {one.topic.name: one for one in view.views(row)}


def test_numbers_of_a_tick_have_names() -> None:
    view, layouts = run_view()

    [numbers] = shown(view, layouts, logged("filter", 2, tick(2))).values()

    assert numbers.message.barrier_disk_psi_0 == 2.5
    assert numbers.message.status == "MODIFIED"
    assert numbers.topic.schema_name == "passafe.table.Tick"


def test_names_that_appear_later_make_the_type_anew() -> None:
    view, layouts = run_view()
    [before] = shown(view, layouts, logged("filter", 0, tick(0, rows=()))).values()

    [after] = shown(view, layouts, logged("filter", 1, tick(1))).values()

    assert not hasattr(before.message, "row_disk_margin")
    assert after.message.row_disk_margin == 0.75


def test_numbers_that_a_message_lacks_are_no_zeros() -> None:
    layout = TableLayout(TOPIC_OF_BODY[type(tick(0))])
    layout.note(tick(0))

    numbers = NamedNumbers(layout).view(logged("filter", 0, tick(0, rows=())), WALL_NS)

    assert math.isnan(numbers.message.row_disk_margin)


def test_a_state_is_a_transform_a_pose_and_a_ball() -> None:
    view, layouts = run_view()
    shown(view, layouts, logged("filter", 1, tick(1)))

    views = shown(view, layouts, logged("plant", 1, state(1)))

    [transform] = views[TRANSFORMS.name].message.transforms
    assert (transform.child_frame_id, transform.translation.x, transform.translation.y) == ("robot", 1.0, 2.0)
    assert transform.timestamp.ToNanoseconds() == WALL_NS + PERIOD_NS
    [pose] = views[POSES.name].message.poses
    assert (pose.position.x, pose.position.y, pose.orientation.w) == (1.0, 2.0, 1.0)
    [robot] = views[ROBOT.name].message.entities
    assert [len(robot.spheres), len(robot.arrows)] == [1, 2]


def test_the_scene_is_shown_at_its_own_rate() -> None:
    view, layouts = run_view()
    counts: dict[str, int] = {}
    for k in range(200):
        for name in shown(view, layouts, logged("plant", k, state(k))):
            counts[name] = counts.get(name, 0) + 1

    assert counts["/passafe/state"] == 200
    assert counts[TRANSFORMS.name] == 10
    assert counts[BARRIERS.name] == 2


def test_barriers_are_coloured_by_what_they_do() -> None:
    scene = Scene(load_scenario("notomista-cai-2020"))

    def red(k: float) -> float:
        one = tick(0, rows=() if k > 0 else ("disk",))
        one = replace(one, barriers=(BarrierReport("disk", (k,)),))
        [message] = scene.barriers(0, one, WALL_NS)
        [entity] = message.message.entities
        return float(entity.lines[0].color.r)

    assert red(-0.1) == pytest.approx(0.85)
    assert red(0.0) == pytest.approx(0.9)
    assert red(0.1) == pytest.approx(0.55)


def test_a_disk_is_a_closed_line_and_a_filled_fan() -> None:
    [message] = Scene(load_scenario("notomista-cai-2020")).barriers(0, None, WALL_NS)
    [disk] = message.message.entities

    places = [(point.x, point.y) for point in disk.lines[0].points]
    assert places[0] == places[-1]
    assert all(math.hypot(*place) == pytest.approx(1.0) for place in places)
    assert len(disk.triangles[0].indices) == 3 * (len(places) - 3)


def test_a_moving_barrier_moves() -> None:
    scene = Scene(load_scenario("moving-disk"))

    [[before], [after]] = [
        [one.pose.position.x for entity in message.message.entities for one in entity.lines]
        for t_ns in (0, 700_000_000)
        for message in scene.barriers(t_ns, None, WALL_NS)
    ]

    assert before != after


def test_two_points_have_a_frame_each_and_joints_none() -> None:
    two = load_scenario("two-robots")
    [transforms, *_] = Scene(two).robot(_state_of(two.plant.x0), None, WALL_NS)
    assert [one.child_frame_id for one in transforms.message.transforms] == ["robot_1", "robot_2"]

    arm = load_scenario(
        "notomista-cai-2020", {"plant.model": "joint-chain", "plant.x0": [0.1, 0.2, 0.3, 0.4], "filter.barriers": []}
    )
    [joints] = Scene(arm).robot(_state_of(arm.plant.x0), None, WALL_NS)
    assert joints.topic is JOINTS
    assert [(one.name, one.position, one.velocity) for one in joints.message.joints] == [
        ("joint_1", 0.1, 0.3),
        ("joint_2", 0.2, 0.4),
    ]


def test_events_and_stops_are_log_lines() -> None:
    lines = [
        log_line(header("plant", 0), body, WALL_NS)
        for body in (Event("warning", "near"), EmergencyStop(7, "smoke"), StopClear(7, "no smoke"))
    ]

    assert [(one.message.level, one.message.message, one.message.name) for one in lines if one is not None] == [
        (Log.WARNING, "near", "plant"),
        (Log.ERROR, "emergency stop: smoke", "plant"),
        (Log.WARNING, "emergency stop cleared: no smoke", "plant"),
    ]
    assert log_line(header("operator", 0), OperatorCommand((0.0,), (), True, "lag"), WALL_NS) is None


def test_without_a_scenario_there_are_numbers_alone() -> None:
    layouts = {topic.name: TableLayout(topic) for topic in TOPICS}

    assert list(shown(RunView(None, layouts, WALL_NS), layouts, logged("plant", 0, state(0)))) == ["/passafe/state"]


def _state_of(x: tuple[float, ...]) -> PlantState:
    return replace(state(0), x=x)


def test_a_car_is_turned_and_has_an_outline() -> None:
    car = load_scenario("unicycle-posts")
    at = replace(_state_of(car.plant.x0), x=(1.0, 2.0, math.pi / 2, 0.0, 0.0))
    pushed = replace(tick(0), x_hat=at.x, u=(4.0, 0.0), u_nominal=(0.0, 0.0))

    views = {view.topic.name: view.message for view in Scene(car).robot(at, pushed, WALL_NS)}

    [transform] = views[TRANSFORMS.name].transforms
    assert (transform.rotation.z, transform.rotation.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    [robot] = views[ROBOT.name].entities
    assert len(robot.lines[0].points) == 5
    [ahead] = robot.arrows
    assert 2 * math.atan2(ahead.pose.orientation.z, ahead.pose.orientation.w) == pytest.approx(math.pi / 2)


def test_levels_are_joints_and_what_pumps_give_no_effort() -> None:
    scenario = scenario_of(two_tanks(), [1.0, 0.7], [0.0, 0.0], degree=1)
    [joints] = Scene(scenario).robot(_state_of(scenario.plant.x0), None, WALL_NS)

    assert [(one.name, one.position, one.velocity) for one in joints.message.joints] == [
        ("joint_1", 1.0, 0.0),
        ("joint_2", 0.7, 0.0),
    ]


def test_arrow_of_many_inputs_is_that_of_their_push() -> None:
    """Three cables pull by (u₁ − (u₂ + u₃)/2, 0.8(u₂ − u₃))."""
    drawn = DrawnPlaces.of(on_three_cables())

    assert drawn.push((0.0,) * 4, (2.0, 1.0, 0.5)) == pytest.approx((1.25, 0.4))
    assert DrawnPlaces.of(two_tanks()).push((1.0, 1.0), (0.5, 0.5)) == ()
