import pytest
from barrier_examples import disk, ellipse, half_plane, not_places
from bokeh.models import DataRange1d, Line, Patch
from bokeh.models.annotations import Legend
from bokeh.plotting import figure
from passafe_dashboard.charts.live_charts import unfilled_table
from passafe_dashboard.charts.plane import plane_chart
from passafe_dashboard.columns import P1, P2, PLACES
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.motion import Circle, Motion, Swing, Travel

SWING = Swing(kind="swing", amplitude_m=(2.0, 0.0), frequency_hz=0.25)
TRAVEL = Travel(kind="travel", velocity_m_per_s=(1.0, 0.0))
ROUND = Circle(kind="circle", radius_m=1.0, frequency_hz=0.5)
STILL = (
    disk("disk"),
    disk("arena", radius=4.0, keep_in=True),
    ellipse("post", (2.0, 0.0), (1.0, 0.5)),
    half_plane("wall", (1.0, 0.0), -3.0),
)


def plane(*barriers: SingleBarrier) -> figure:
    table = unfilled_table("robot", PLACES[0])
    return plane_chart(barriers, trail=table, robot=table, starts=[(0.0, 0.0)])


def words(chart: figure) -> list[str]:
    return [item.label.value for part in chart.above if isinstance(part, Legend) for item in part.items]


def places(chart: figure, kind: type) -> list[dict[str, list[float]]]:
    """Return the data of the regions' glyphs of one kind."""
    return [
        {column: list(one.data_source.data[column]) for column in (P1, P2)}
        for one in chart.renderers
        if isinstance(one.glyph, kind) and one.glyph.x == P1 and one.data_source.name != "robot"
    ]


def middle(data: dict[str, list[float]]) -> tuple[float, float]:
    """Middle of a polygon's extent."""
    return (min(data[P1]) + max(data[P1])) / 2, (min(data[P2]) + max(data[P2])) / 2


def named(chart: figure) -> set[str]:
    return {one.data_source.name for one in chart.renderers} - {None, "robot"}


def test_every_kind_of_place_is_drawn_with_one_legend_entry() -> None:
    chart = plane(*STILL)
    assert words(chart) == ["keep out", "trail", "start", "robot"]
    assert len(places(chart, Patch)) == 4
    assert len(places(chart, Line)) == 2  # borders of the arena and the wall; what they shut off has no line
    assert named(chart) == set()


def test_region_of_two_points_is_drawn_once() -> None:
    points = [(one, k) for one in STILL for k in (1, 2)]
    both = [one.model_copy(update={"name": f"{one.name} {k}", "point": k}) for one, k in points]
    assert len(plane(*both).renderers) == len(plane(*STILL).renderers)
    other = disk("another", (0.0, 0.1))
    assert len(places(plane(STILL[0], other), Patch)) == 2


def test_barriers_without_outline_are_not_drawn() -> None:
    chart = plane(*not_places())
    assert words(chart) == ["trail", "start", "robot"]
    assert places(chart, Patch) == []


def test_moving_regions_have_named_tables_on_the_live_page() -> None:
    moving = (
        STILL[0],
        disk("visitor", (1.0, 2.0), 0.5, motion=SWING),
        ellipse("cage", (0.0, 0.0), (3.0, 2.0), keep_in=True, motion=ROUND),
        half_plane("piston", (1.0, 0.0), -3.0, motion=SWING),
    )
    chart = plane(*moving)
    assert named(chart) == {"moving_1", "moving_2", "moving_2_border", "moving_3", "moving_3_border"}
    drawn = next(one for one in chart.renderers if one.data_source.name == "moving_1")
    assert middle(dict(drawn.data_source.data)) == pytest.approx((1.0, 2.0))


@pytest.mark.parametrize(("motion", "held"), [(TRAVEL, False), (SWING, True)])
def test_departing_outline_does_not_stretch_the_view(motion: Motion, held: bool) -> None:
    chart = plane(disk("bus", radius=0.5, motion=motion))
    assert isinstance(chart.x_range, DataRange1d)
    in_view = [one for one in chart.x_range.renderers if isinstance(one.glyph, Patch)]
    assert bool(in_view) is held


def test_half_plane_does_not_extend_the_view() -> None:
    piston = half_plane("piston", (1.0, 0.0), -3.0, motion=SWING)
    chart = plane(STILL[3], piston)
    assert isinstance(chart.x_range, DataRange1d)
    assert not [one for one in chart.x_range.renderers if isinstance(one.glyph, Patch)]
