from dataclasses import replace

import numpy as np
import pytest
from bokeh.models import Circle, DataRange1d, Line, Patch
from bokeh.models.annotations import Legend
from bokeh.plotting import figure
from passafe_dashboard.charts.live_charts import unfilled_table
from passafe_dashboard.charts.plane import plane_figure
from passafe_dashboard.charts.regions import EARLIER, LIVE, Drawing
from passafe_dashboard.columns import P1, P2, PLACES
from passafe_dashboard.obstacles import Disk, Ellipse, HalfPlane, Limit, Obstacle, Separation, SpeedLimit
from passafe_dashboard.svg.chart import Placed, picture
from passafe_services.scenarios.barrier_schema import Circle as CircleMotion
from passafe_services.scenarios.barrier_schema import Swing, Travel

SWING = Swing(kind="swing", amplitude_m=(2.0, 0.0), frequency_hz=0.25)
TRAVEL = Travel(kind="travel", velocity_m_per_s=(1.0, 0.0))
ROUND = CircleMotion(kind="circle", radius_m=1.0, frequency_hz=0.5)
STILL = (
    Disk(name="disk", centre=(0.0, 0.0), radius=1.0),
    Disk(name="arena", centre=(0.0, 0.0), radius=4.0, keep_in=True),
    Ellipse(name="post", centre=(2.0, 0.0), semi_axes=(1.0, 0.5)),
    HalfPlane(name="wall", normal=(1.0, 0.0), offset=-3.0),
)
NO_PLACES: tuple[Obstacle, ...] = (
    SpeedLimit(name="speed", limit=1.0, first=2),
    Separation(name="apart", distance=1.0),
    Limit(name="joint", place=0, bound=1.0, upper=True, unit="rad"),
)


def plane(*obstacles: Obstacle, drawing: Drawing = LIVE) -> figure:
    table = unfilled_table("robot", PLACES[0])
    return plane_figure(obstacles, trail=table, robot=table, starts=[(0.0, 0.0)], drawing=drawing)


def words(chart: figure) -> list[str]:
    return [item.label.value for part in chart.above if isinstance(part, Legend) for item in part.items]


def places(chart: figure, kind: type) -> list[dict[str, list[float]]]:
    """Data of the regions' glyphs of one kind."""
    return [
        {column: list(one.data_source.data[column]) for column in (P1, P2)}
        for one in chart.renderers
        if isinstance(one.glyph, kind) and one.glyph.x == P1 and one.data_source.name != "robot"
    ]


def named(chart: figure) -> set[str]:
    return {one.data_source.name for one in chart.renderers} - {None, "robot"}


def test_every_kind_of_place_is_drawn_with_one_legend_entry() -> None:
    chart = plane(*STILL)
    assert words(chart) == ["keep out", "trail", "start", "robot"]
    assert len(places(chart, Circle)) == 1
    assert len(places(chart, Patch)) == 3
    assert len(places(chart, Line)) == 2  # borders of the arena and the wall; what they shut off has no line
    assert named(chart) == set()


def test_what_holds_for_two_points_is_drawn_once() -> None:
    both = [replace(one, name=f"{one.name} {k}", first=2 * k) for one in STILL for k in (0, 1)]
    assert len(plane(*both).renderers) == len(plane(*STILL).renderers)
    other = replace(STILL[0], name="another", centre=(0.0, 0.1))
    assert len(places(plane(STILL[0], other), Circle)) == 2


def test_barriers_that_are_no_places_are_not_drawn() -> None:
    chart = plane(*NO_PLACES)
    assert words(chart) == ["trail", "start", "robot"]
    assert places(chart, Patch) == places(chart, Circle) == []


def test_a_live_page_finds_what_moves_in_tables_of_its_own() -> None:
    moving = (
        STILL[0],
        Disk(name="visitor", centre=(1.0, 2.0), radius=0.5, motion=SWING),
        Ellipse(name="cage", centre=(0.0, 0.0), semi_axes=(3.0, 2.0), keep_in=True, motion=ROUND),
        HalfPlane(name="piston", normal=(1.0, 0.0), offset=-3.0, motion=SWING),
    )
    chart = plane(*moving)
    assert named(chart) == {"moving_1", "moving_2", "moving_2_border", "moving_3", "moving_3_border"}
    disk = next(one for one in chart.renderers if one.data_source.name == "moving_1")
    assert dict(disk.data_source.data) == {P1: [1.0], P2: [2.0]}


def test_over_a_run_what_moves_is_drawn_where_it_was_and_where_it_is() -> None:
    visitor = Disk(name="visitor", centre=(1.0, 2.0), radius=0.5, motion=SWING)
    chart = plane(visitor, drawing=Drawing(begin_s=0.0, end_s=5.0))
    disks = places(chart, Circle)
    assert len(disks) == EARLIER + 1
    assert disks[-1] == {P1: [pytest.approx(3.0)], P2: [2.0]}  # a quarter of a period into the swing
    assert [disk[P1][0] for disk in disks[:-1]] == pytest.approx(
        [1 + 2 * np.sin(np.pi / 2 * t) for t in np.arange(EARLIER) * 5 / EARLIER]
    )
    [way] = places(chart, Line)
    assert (min(way[P1]), max(way[P1])) == pytest.approx((-1, 3), abs=1e-3)
    assert words(chart)[:2] == ["keep out", "keep out, earlier"]
    assert named(chart) == set()


@pytest.mark.parametrize(("drawing", "held"), [(LIVE, False), (Drawing(begin_s=0.0, end_s=5.0), True)])
def test_what_goes_away_for_good_does_not_take_the_live_view_along(drawing: Drawing, held: bool) -> None:
    chart = plane(Disk(name="bus", centre=(0.0, 0.0), radius=0.5, motion=TRAVEL), drawing=drawing)
    assert isinstance(chart.x_range, DataRange1d)
    in_view = [one for one in chart.x_range.renderers if isinstance(one.glyph, Circle)]
    assert bool(in_view) is held


def test_a_wall_has_no_end_to_be_in_view() -> None:
    piston = HalfPlane(name="piston", normal=(1.0, 0.0), offset=-3.0, motion=SWING)
    for drawing in (LIVE, Drawing(begin_s=0.0, end_s=1.0)):
        chart = plane(STILL[3], piston, drawing=drawing)
        assert isinstance(chart.x_range, DataRange1d)
        assert not [one for one in chart.x_range.renderers if isinstance(one.glyph, Patch)]


def test_every_kind_of_place_can_be_drawn_without_a_browser() -> None:
    moving = Ellipse(name="cage", centre=(0.0, 0.0), semi_axes=(3.0, 2.0), keep_in=True, motion=ROUND)
    chart = plane(*STILL, moving, drawing=Drawing(begin_s=0.0, end_s=5.0))
    text = picture([Placed(chart, 0, 0, 400, 400)], width=400, height=400, title="a", description="b")
    assert text.count("<circle") >= 1
    assert text.count('stroke-dasharray="6"') == EARLIER + 1
    assert 'stroke="None"' not in text
