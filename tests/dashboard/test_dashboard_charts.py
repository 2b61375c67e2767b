from collections.abc import Iterator

import pytest
from barrier_examples import disk, half_plane
from bokeh.models import ColumnDataSource, DataRange1d, HBar, Line
from bokeh.models.annotations import Legend
from bokeh.plotting import figure
from closed_form import paper_scenario
from passafe_dashboard.charts.barriers import MOST_WITH_FILTER, chain_chart, h_chart, signed_log_ticks
from passafe_dashboard.charts.energy import power_margin_chart, tank_chart
from passafe_dashboard.charts.live_charts import live_charts
from passafe_dashboard.charts.over_time import live_range
from passafe_dashboard.charts.plane import plane_chart
from passafe_dashboard.charts.timeline import age_chart, status_chart
from passafe_dashboard.columns import P1, P2, PLACES, TIME, ZERO, ColumnLayout, drawn_columns, signed_log
from passafe_protocol.messages import FilterStatus

LAYOUT = ColumnLayout(
    barriers=(
        disk("disk"),
        half_plane("wall", (1.0, 0.0), -3.0),
    ),
    levels=(3, 3),
)


def table(*columns: str) -> ColumnDataSource:
    return ColumnDataSource({column: [0.0, 1.0] for column in columns})


def every_chart() -> Iterator[figure]:
    x_range = DataRange1d()
    ticks = table(*drawn_columns(tuple(LAYOUT.tick_columns), LAYOUT.log_columns))
    states = table(*drawn_columns(tuple(LAYOUT.state_columns), ()))
    yield h_chart(LAYOUT, ticks=ticks, states=states, x_range=x_range)
    chain = chain_chart(LAYOUT, ticks=ticks, x_range=x_range)
    assert chain is not None
    yield chain
    yield power_margin_chart(source=ticks, x_range=x_range)
    yield tank_chart(ticks=ticks, x_range=x_range)
    yield age_chart(ticks=ticks, x_range=x_range)
    yield status_chart(source=ticks, x_range=x_range)
    yield plane_chart(LAYOUT.barriers, trail=states, robot=table(P1, P2), starts=[(2.0, 2.0)])


def chart_named(name: str) -> figure:
    return next(chart for chart in every_chart() if chart.name == name)


def lines(chart: figure) -> list[Line]:
    return [part.glyph for part in chart.renderers if isinstance(part.glyph, Line)]


def legend_words(chart: figure) -> list[str]:
    return [item.label.value for part in chart.above if isinstance(part, Legend) for item in part.items]


@pytest.mark.parametrize("name", ["h", "chain", "power_margin", "tank", "ages", "status", "plane"])
def test_axes_say_quantity_and_unit(name: str) -> None:
    chart = chart_named(name)
    assert chart.xaxis[0].axis_label.endswith(("(s)", "(m)"))
    assert "(" in chart.yaxis[0].axis_label or name == "status"
    assert chart.toolbar.logo is None


@pytest.mark.parametrize("name", ["h", "chain", "power_margin", "tank"])
def test_the_zero_line_is_drawn_and_named(name: str) -> None:
    chart = chart_named(name)
    assert any((line.x, line.y) == (TIME, ZERO) for line in lines(chart))
    assert any("= 0" in words for words in legend_words(chart))


@pytest.mark.parametrize("name", ["h", "chain", "power_margin", "tank", "ages"])
def test_rounding_does_not_fill_a_chart(name: str) -> None:
    assert chart_named(name).y_range.min_interval > 1e-3


def test_every_barrier_has_its_own_named_lines() -> None:
    h, chain, *_ = every_chart()
    assert legend_words(h)[1:] == [
        "h of disk, measured",
        "h of disk, filter",
        "h of wall, measured",
        "h of wall, filter",
    ]
    assert legend_words(chain)[1:] == ["ψ₁ of disk", "ψ₂ of disk", "ψ₁ of wall", "ψ₂ of wall"]
    drawn = [line for line in lines(chain) if line.y not in (ZERO, "y")]
    assert len({(line.line_color, tuple(line.line_dash)) for line in drawn}) == 4


def test_filter_lines_are_left_out_with_many_barriers() -> None:
    walls = tuple(half_plane(f"wall {i}", (1.0, 0.0), -3.0 - i) for i in range(MOST_WITH_FILTER + 1))
    layout = ColumnLayout(barriers=walls, levels=(3,) * len(walls))
    ticks = table(*drawn_columns(tuple(layout.tick_columns), layout.log_columns))
    states = table(*drawn_columns(tuple(layout.state_columns), ()))
    live = h_chart(layout, ticks=ticks, states=states, x_range=DataRange1d())
    assert legend_words(live)[1:] == [f"h of wall {i}, measured" for i in range(MOST_WITH_FILTER + 1)]


def test_a_barrier_of_relative_degree_zero_has_no_chain() -> None:
    layout = ColumnLayout(barriers=LAYOUT.barriers[:1], levels=(1,))
    assert chain_chart(layout, ticks=table(TIME, ZERO), x_range=DataRange1d()) is None


def test_status_chart_has_rows_in_order_of_severity() -> None:
    chart = chart_named("status")
    assert chart.yaxis[0].major_label_overrides == {status.severity: status.name for status in FilterStatus}
    assert isinstance(chart.renderers[0].glyph, HBar)


def test_signed_log_ticks_are_symmetric_and_in_place() -> None:
    ticks = signed_log_ticks()
    assert ticks[0.0] == "0"
    assert ticks[signed_log(100.0)] == "100"
    assert ticks[-signed_log(0.1)] == "−0.1"
    assert {-place for place in ticks} == set(ticks)


def test_a_live_range_follows_the_newest_sample() -> None:
    assert live_range(20.0).follow == "end"
    assert live_range(20.0).follow_interval == 20.0


def test_the_page_has_a_chart_for_everything() -> None:
    charts = live_charts(ColumnLayout.of(paper_scenario()), starts=((2.0, 2.0),), window_s=20.0)
    assert set(charts.divs) == {"plane", "h", "chain", "power_margin", "tank", "status", "ages"}
    for name in ("ticks", "states", "robot"):
        assert f'"name":"{name}"' in charts.script
    assert "NaN" not in charts.script.replace('"nan"', "")


def test_without_barriers_there_are_no_charts_of_them() -> None:
    charts = live_charts(ColumnLayout(barriers=(), levels=()), starts=((2.0, 2.0),), window_s=20.0)
    assert set(charts.divs) == {"plane", "power_margin", "tank", "status", "ages"}


def test_joints_have_no_plane() -> None:
    charts = live_charts(ColumnLayout(barriers=(), levels=(), points=0), starts=(), window_s=20.0)
    assert set(charts.divs) == {"power_margin", "tank", "status", "ages"}


def test_two_robots_have_a_trail_and_a_place_each() -> None:
    columns = [column for place in PLACES for column in place]
    both = [(2.0, 2.0), (0.0, 1.0)]
    chart = plane_chart((), trail=table(*columns), robot=table(*columns), starts=both)
    assert legend_words(chart) == ["trail 1", "start", "robot 1", "trail 2", "robot 2"]
    trails = [line for line in lines(chart) if line.x in {"p1_m", "p3_m"}]
    assert [(line.x, line.y) for line in trails] == list(PLACES)
    assert len({(line.line_color, tuple(line.line_dash)) for line in trails}) == 2
