import pytest
from barrier_examples import speed_limit
from closed_form import MS, h, paper_scenario, position, state, tick
from passafe_dashboard.columns import ColumnLayout, drawn_columns
from passafe_dashboard.live.feed import Feed
from passafe_protocol.messages import BarrierReport
from passafe_services.scenarios.load import load_scenario

LAYOUT = ColumnLayout.of(paper_scenario())


def test_a_barrier_has_as_many_psi_as_class_k_functions() -> None:
    assert LAYOUT.levels == (3,)
    assert LAYOUT.chain == ((0, 0), (0, 1), (0, 2))
    assert LAYOUT.names == ("disk",)
    assert LAYOUT.h_unit == "m²"


def test_values_of_a_tick_stand_under_their_columns() -> None:
    values = LAYOUT.tick_values(tick(500, slack=0.25, state_age_ns=3 * MS, command_age_ns=7 * MS))
    assert values is not None
    named = dict(zip(LAYOUT.tick_columns, values, strict=True))
    assert named["status"] == 2
    assert named["slack_w"] == 0.25
    assert named["state_age_ms"] == pytest.approx(3.0)
    assert named["command_age_ms"] == pytest.approx(7.0)
    assert named["psi_0_0"] == h(0.5)
    assert named["psi_0_2"] == 100 * h(0.5)


def test_values_of_a_state_stand_under_their_columns() -> None:
    values = LAYOUT.state_values(state(500), [h(0.5)])
    named = dict(zip(LAYOUT.state_columns, values, strict=True))
    assert (named["p1_m"], named["p2_m"]) == position(0.5)
    assert named["h_0"] == pytest.approx(h(0.5))


@pytest.mark.parametrize(
    "barriers", [(), (BarrierReport("disk", (1.0, 2.0)),), (BarrierReport("disk", (1.0, 2.0, 3.0)),) * 2]
)
def test_a_tick_of_another_scenario_has_no_values(barriers: tuple[BarrierReport, ...]) -> None:
    assert LAYOUT.tick_values(tick(0, barriers=barriers)) is None


@pytest.mark.parametrize("x", [(1.0,), (1.0, 2.0, 3.0), ()])
def test_a_state_of_another_scenario_has_no_values(x: tuple[float, ...]) -> None:
    feed = Feed(paper_scenario())
    assert feed.measured_h(state(0, x=x)) is None
    assert feed.measured_h(state(0, x=(1.0, 2.0, 3.0, 4.0))) is not None


def test_two_points_have_two_places_and_joints_none() -> None:
    both = ColumnLayout(barriers=(speed_limit("speed", 2.0),), levels=(2,), points=2, states=8)
    values = both.state_values(state(0, x=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.6, 0.8)), [3.0])
    assert list(both.state_columns) == ["p1_m", "p2_m", "p3_m", "p4_m", "h_0"]
    assert values == [1.0, 2.0, 3.0, 4.0, pytest.approx(3.0)]
    joints = ColumnLayout(barriers=(), levels=(), points=0, states=2)
    assert joints.place_columns == ()
    assert joints.state_values(state(0, x=(1.0, 2.0)), []) == []


def test_page_shows_h_and_displacement_at_the_time_of_the_state() -> None:
    motion = {"kind": "swing", "amplitude_m": (2.0, 0.0), "frequency_hz": 0.25}
    [still] = paper_scenario().model_dump()["filter"]["barriers"]
    barriers = [still, still | {"name": "moving", "motion": motion}]
    feed = Feed(load_scenario("notomista-cai-2020", {"filter.barriers": barriers}))
    after_1_s = state(1000, x=(2.0, 0.0, 0.0, 0.0))
    assert feed.displacements_m(after_1_s) == {"moving_1": (2.0, 0.0)}
    assert feed.measured_h(after_1_s) == [3.0, -1.0]


def test_drawn_columns_begin_with_begin_and_end() -> None:
    assert drawn_columns(("a", "b")) == ("start_s", "time_s", "a", "b")
