import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from math import hypot, nan

import numpy as np
import pytest
from barrier_examples import disk
from bokeh.models import Annulus, ColumnDataSource, HBar, Line, Patch, Range1d, Scatter
from closed_form_series import run_series
from hypothesis import given
from hypothesis import strategies as st
from passafe_dashboard.charts.run_charts import run_charts
from passafe_dashboard.charts.style import plain_figure
from passafe_dashboard.errors import UndrawableError
from passafe_dashboard.svg.chart import Placed, picture
from passafe_dashboard.svg.extent import Extent, extent_of, round_ticks, same_scale, ticks_of
from passafe_dashboard.svg.marks import Scale, draw, element

SVG = "{http://www.w3.org/2000/svg}"
SAME = Scale(x=lambda v: v, y=lambda v: -v, per_unit=1.0)


def chart_of(glyph: object, **columns: list[float]):  # noqa: ANN201 - a figure
    chart = plain_figure(name="a", x_label="x (m)", y_label="y (m)", height=100)
    chart.add_glyph(ColumnDataSource(columns), glyph)
    return chart


def test_a_line_is_a_path_that_gaps_interrupt() -> None:
    path = draw(Line(x="x", y="y"), [0.0, 1.0, nan, 2.0, 3.0], [0.0, 1.0, 5.0, 0.0, 0.5], SAME)
    assert 'd="M0.00 0.00L1.00 -1.00M2.00 0.00L3.00 -0.50"' in path.replace("-0.00", "0.00")


def test_an_outline_s_dashes_have_lengths_and_no_outline_is_none() -> None:
    places = ([0.0, 1.0, 1.0], [0.0, 0.0, 1.0], SAME)
    assert 'stroke-dasharray="2 4"' in draw(Patch(x="x", y="y", line_dash="dotted"), *places)
    assert 'stroke-dasharray="3 1"' in draw(Line(x="x", y="y", line_dash=[3, 1]), *places)
    assert "dasharray" not in draw(Patch(x="x", y="y", line_dash="solid"), *places)
    bare = draw(Patch(x="x", y="y", line_color=None), *places)
    assert 'stroke="none"' in bare
    assert "stroke-width" not in bare


def test_a_dashed_line_stays_dashed() -> None:
    assert 'stroke-dasharray="6"' in draw(Line(x="x", y="y", line_dash="dashed"), [0.0], [0.0], SAME)


@pytest.mark.parametrize(("marker", "tag"), [("circle", "<circle"), ("square", "<rect")])
def test_markers_are_drawn_once_a_point(marker: str, tag: str) -> None:
    drawn = draw(Scatter(x="x", y="y", marker=marker), [0.0, nan, 1.0], [0.0, 0.0, 1.0], SAME)
    assert drawn.count(tag) == 2


def test_what_is_not_known_is_refused_and_named() -> None:
    with pytest.raises(UndrawableError, match="HBar"):
        draw(HBar(), [0.0], [0.0], SAME)
    with pytest.raises(UndrawableError, match="marker star"):
        draw(Scatter(x="x", y="y", marker="star"), [0.0], [0.0], SAME)
    with pytest.raises(UndrawableError, match="varies"):
        draw(Scatter(x="x", y="y", size={"field": "s"}), [0.0], [0.0], SAME)
    with pytest.raises(UndrawableError, match="Annulus"):
        draw(Annulus(), [0.0], [0.0], SAME)


def test_attributes_are_escaped() -> None:
    assert element("a", b='"<&') == "<a b='\"&lt;&amp;'/>"


def test_an_axis_holds_the_data_and_the_padding() -> None:
    chart = chart_of(Line(x="a", y="b"), a=[1.0, 3.0], b=[-1.0, 4.0])
    assert extent_of(chart, "x") == pytest.approx((0.9, 3.1))
    assert extent_of(chart, "y") == pytest.approx((-1.25, 4.25))


def test_an_axis_of_one_value_or_none_is_still_an_interval() -> None:
    assert extent_of(chart_of(Line(x="a", y="b"), a=[2.0], b=[nan]), "x").span > 0
    assert extent_of(chart_of(Line(x="a", y="b"), a=[2.0], b=[nan]), "y") == pytest.approx((-0.05, 1.05))


def test_an_axis_is_never_shorter_than_its_least_span() -> None:
    chart = chart_of(Line(x="a", y="b"), a=[0.0, 1.0], b=[0.0, 1e-9])
    chart.y_range.min_interval = 0.5
    assert extent_of(chart, "y").span == pytest.approx(0.5)


def test_a_range_that_is_not_automatic_is_refused() -> None:
    chart = chart_of(Line(x="a", y="b"), a=[1.0], b=[1.0])
    chart.y_range = Range1d(start=0, end=1)
    with pytest.raises(UndrawableError, match="Range1d"):
        extent_of(chart, "y")


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6))
def test_ticks_are_few_round_and_inside(low: float, span: float) -> None:
    extent = Extent(low, low + span)
    ticks = round_ticks(extent)
    assert len(ticks) <= 8
    if extent.span > 1e-9 * abs(low):
        assert len(ticks) >= 1
    for tick in ticks:
        assert extent.low - 1e-9 * (abs(low) + span) <= tick.place <= extent.high + 1e-9 * (abs(low) + span)


def test_ticks_read_as_a_person_would_write_them() -> None:
    assert [tick.text for tick in round_ticks(Extent(-1.1, 2.3))] == ["−1", "0", "1", "2"]
    assert [tick.text for tick in round_ticks(Extent(-0.6, 0.6))] == ["−0.6", "−0.4", "−0.2", "0", "0.2", "0.4", "0.6"]
    assert [tick.text for tick in round_ticks(Extent(0.0, 10.0))] == ["0", "2", "4", "6", "8", "10"]


def test_equal_scales_stretch_one_axis_only() -> None:
    x, y = same_scale(Extent(0.0, 10.0), Extent(0.0, 2.0), 100.0, 100.0)
    assert x == (0.0, 10.0)
    assert y == pytest.approx((-4.0, 6.0))


def test_a_picture_is_well_formed_and_has_words() -> None:
    charts = run_charts(run_series(), bins=200)
    placed = [Placed(charts["plane"], 0, 0, 400, 400), Placed(charts["h"], 400, 0, 400, 200)]
    text = picture(placed, width=800, height=400, title="a < b", description="what & why")
    root = ET.fromstring(text)  # noqa: S314 - our own output
    assert root.get("role") == "img"
    assert root.findtext(f"{SVG}title") == "a < b"
    assert root.findtext(f"{SVG}desc") == "what & why"
    words = [node.text for node in root.iter(f"{SVG}text")]
    for word in ("position p₁ (m)", "barrier h (m²)", "keep out", "limit: h = 0"):
        assert word in words
    assert "http" not in text.replace("http://www.w3.org/2000/svg", "")


def test_the_disk_of_the_picture_is_round_and_of_its_size() -> None:
    chart = run_charts(run_series(), bins=200)["plane"]
    root = ET.fromstring(  # noqa: S314 - our own output
        picture([Placed(chart, 0, 0, 400, 400)], width=400, height=400, title="a", description="b")
    )
    outline = next(node for node in root.iter(f"{SVG}path") if node.get("fill-opacity") == "0.18").get("d", "")
    places = [(float(x), float(y)) for x, y in re.findall(r"[ML](\S+) ([\d.-]+)", outline)]
    ticks = {
        node.text: float(node.get("x", "0")) for node in root.iter(f"{SVG}text") if node.get("text-anchor") == "middle"
    }
    left, right = (edge(x for x, _ in places) for edge in (min, max))
    assert (right - left) / 2 == pytest.approx((ticks["1"] - ticks["−1"]) / 2, abs=0.02)
    assert (right + left) / 2 == pytest.approx(ticks["0"], abs=0.02)
    middle = (min(y for _, y in places) + max(y for _, y in places)) / 2
    assert all(hypot(x - ticks["0"], y - middle) == pytest.approx((right - left) / 2, abs=0.02) for x, y in places)


def test_a_legend_with_many_entries_has_rows_inside_the_chart() -> None:
    series = run_series(1_000)
    disks = tuple(disk(f"disk number {n}") for n in range(6))
    many = replace(series, barriers=disks, h=np.repeat(series.h, 6, axis=0))
    chart = run_charts(many, bins=100)["h"]
    text = picture([Placed(chart, 0, 0, 400, 300)], width=400, height=300, title="a", description="b")
    words = [node for node in ET.fromstring(text).iter(f"{SVG}text") if "disk" in (node.text or "")]  # noqa: S314
    assert len(words) == 6
    places = {(node.get("x"), node.get("y")) for node in words}
    assert len(places) == 6
    assert len({y for _, y in places}) > 2
    assert min(float(node.get("x", "-1")) for node in words) > 0
    assert min(float(node.get("y", "-1")) for node in words) > 0


def test_the_same_run_gives_the_same_bytes() -> None:
    def drawn() -> str:
        charts = run_charts(run_series(2_000), bins=100)
        return picture([Placed(charts["h"], 0, 0, 400, 200)], width=400, height=200, title="a", description="b")

    assert drawn() == drawn()


def test_fixed_ticks_keep_their_words() -> None:
    chart = chart_of(Line(x="a", y="b"), a=[0.0, 1.0], b=[0.0, 1.0])
    chart.yaxis.ticker = [0.0, 1.0, 5.0]
    chart.yaxis.major_label_overrides = {0.0: "none", 1.0: "one", 5.0: "five"}
    assert [tick.text for tick in ticks_of(chart, "y", Extent(-1.0, 2.0))] == ["none", "one"]
