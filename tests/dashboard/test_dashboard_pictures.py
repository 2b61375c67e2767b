"""Pictures of runs and of experiments, checked on matplotlib's artists and on the SVG."""

import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from barrier_examples import disk, ellipse, half_plane, not_places
from closed_form_series import run_series
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from passafe_dashboard.palette import LINE_DASHES, PAPER, UNSAFE_COLOUR, line_style
from passafe_dashboard.pictures.__main__ import main
from passafe_dashboard.pictures.keep_out import EARLIER
from passafe_dashboard.pictures.line_chart import Curve, LineChart, draw_chart
from passafe_dashboard.pictures.run_picture import draw_run, run_picture
from passafe_dashboard.pictures.svg_file import DASHES, svg_text
from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.motion import Circle, Swing

SVG = "{http://www.w3.org/2000/svg}"
SWING = Swing(kind="swing", amplitude_m=(2.0, 0.0), frequency_hz=0.25)
ROUND = Circle(kind="circle", radius_m=1.0, frequency_hz=0.5)


def words(text: str) -> list[str]:
    return ["".join(node.itertext()) for node in ET.fromstring(text).iter(f"{SVG}text")]  # noqa: S314 - our own output


def charts_of_run(*barriers: SingleBarrier) -> list[Axes]:
    series = run_series(1_000)
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    draw_run(figure, replace(series, barriers=barriers, h=np.repeat(series.h, len(barriers), axis=0)))
    figure.draw_without_rendering()
    return figure.axes


def edges(axes: Axes) -> list[Line2D]:
    return [line for line in axes.findobj(Line2D) if line.get_color() == UNSAFE_COLOUR]


def in_legend(axes: Axes) -> list[str]:
    legend = axes.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def test_a_run_s_picture_has_the_paper_s_plots() -> None:
    text = run_picture(run_series(), title="circle")
    for word in ("position p₂ (m)", "barrier h (m²)", "power margin (W)", "keep out", "limit: h = 0"):
        assert word in words(text)
    description = ET.fromstring(text).findtext(f"{SVG}desc") or ""  # noqa: S314 - our own output
    assert "disk lowest sample 0.44 at 7.854 s" in description
    assert "lowest sample 0.1 W at 9.425 s" in description


def test_a_run_without_barriers_has_a_taller_power_margin() -> None:
    series = run_series()
    text = run_picture(replace(series, h=series.h[:0], barriers=()), title="circle")
    assert "power margin (W)" in words(text)
    assert "barrier h (m)" not in words(text)
    [_, lower] = charts_of_run()
    [_, _, below_h] = charts_of_run(disk("disk"))
    assert lower.get_position().height > 1.8 * below_h.get_position().height


def test_a_run_of_joints_has_no_plane() -> None:
    text = run_picture(replace(run_series(), points=0), title="joints")
    assert not any("position" in word for word in words(text))


def test_a_picture_is_small_enough_for_a_readme() -> None:
    assert len(run_picture(run_series(), title="circle")) < 150_000


def test_the_same_run_gives_the_same_bytes() -> None:
    assert run_picture(run_series(2_000), title="a") == run_picture(run_series(2_000), title="a")


def test_svg_has_title_and_description_and_no_metadata() -> None:
    text = svg_text(lambda _: None, width=400, height=200, title="a < b", description="what & why")
    root = ET.fromstring(text)  # noqa: S314 - our own output
    assert root.get("role") == "img"
    assert root.findtext(f"{SVG}title") == "a < b"
    assert root.findtext(f"{SVG}desc") == "what & why"
    assert (root.get("width"), root.get("height")) == ("400pt", "200pt")
    assert "<metadata>" not in text
    assert set(re.findall(r"https?://([^/\"]+)", text)) == {"www.w3.org"}


def test_user_settings_of_matplotlib_have_no_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    import matplotlib as mpl  # noqa: PLC0415 - only this test changes its settings

    before = run_picture(run_series(1_000), title="a")
    monkeypatch.setitem(mpl.rcParams, "lines.linewidth", 9.0)
    monkeypatch.setitem(mpl.rcParams, "axes.facecolor", "black")
    assert run_picture(run_series(1_000), title="a") == before


def test_every_dash_of_the_palette_is_drawn_and_differs() -> None:
    assert list(DASHES) == list(LINE_DASHES)
    assert len({str(dash) for dash in DASHES.values()}) == len(LINE_DASHES)


def test_a_disk_is_round_and_of_its_size() -> None:
    plane = charts_of_run(disk("disk", (0.5, -0.5)))[0]
    [round_one] = plane.findobj(Polygon)
    points = round_one.get_path().vertices
    assert np.hypot(*(points - (0.5, -0.5)).T) == pytest.approx(1.0)
    across, up = np.ptp(plane.transData.transform(points), axis=0)
    assert across == pytest.approx(up)


def test_every_region_is_drawn_and_bounded_ones_are_in_view() -> None:
    plane = charts_of_run(
        disk("disk"),
        disk("arena", radius=4.0, keep_in=True),
        ellipse("post", (7.0, 0.0), (1.0, 0.5)),
        half_plane("wall", (1.0, 0.0), -30.0),
        *not_places(),
    )[0]
    assert len(plane.findobj(Polygon)) == 4
    assert len(edges(plane)) == 4
    assert in_legend(plane) == ["keep out", "trail", "start", "robot"]
    low, high = plane.get_xlim()
    assert -30 < low < -4
    assert 8 < high < 20


def test_a_moving_region_is_drawn_on_its_path_and_at_the_end() -> None:
    visitor = disk("visitor", (1.0, 2.0), 0.5, motion=SWING)
    plane = charts_of_run(visitor)[0]
    assert len(plane.findobj(Polygon)) == EARLIER + 1
    [path] = [line for line in edges(plane) if line.get_linestyle() == ":"]
    t_end = 0.999
    assert path.get_xdata()[0] == 1.0
    assert path.get_xdata()[-1] == pytest.approx(1 + 2 * np.sin(np.pi / 2 * t_end))
    assert in_legend(plane)[:2] == ["keep out", "keep out, earlier"]


def test_fills_of_an_unbounded_region_do_not_cover_one_another() -> None:
    cage = ellipse("cage", (0.0, 0.0), (3.0, 2.0), keep_in=True, motion=ROUND)
    plane = charts_of_run(cage)[0]
    assert len(plane.findobj(Polygon)) == 1
    assert sum(line.get_linestyle() == "--" for line in edges(plane)) == EARLIER


def test_many_barriers_have_a_legend_inside_the_picture() -> None:
    disks = [disk(f"disk number {n}") for n in range(7)]
    axes = charts_of_run(*disks)[1]
    legend = axes.get_legend()
    assert legend is not None
    assert len(in_legend(axes)) == 8
    box, picture = legend.get_window_extent(), axes.figure.bbox
    assert picture.x0 <= box.x0 < box.x1 <= picture.x1
    assert box.y1 <= picture.y1


def test_least_ordinate_is_in_view_and_limit_is_drawn() -> None:
    axes = Figure().add_subplot()
    curve = Curve(label="both", style=1, x=(0.0, 1.0), y=(2.0, 3.0), low=(1.5, 2.5), high=(2.5, 3.5))
    chart = LineChart(x_label="x", y_label="y", curves=(curve,), limit=4.0, limit_label="not tried beyond", least=-1.0)
    draw_chart(axes, chart)
    assert axes.get_ylim()[0] <= -1.0
    assert axes.get_ylim()[1] >= 4.0
    assert in_legend(axes) == ["both", "not tried beyond"]


@pytest.mark.parametrize(
    ("limit", "low", "scale"),
    [(0.0, 1.3e-5, "symlog"), (0.0, -0.1, "linear"), (0.25, 1.3e-5, "linear"), (None, 1.3e-5, "linear")],
)
def test_values_just_above_a_limit_of_0_are_seen(limit: float | None, low: float, scale: str) -> None:
    axes = Figure().add_subplot()
    curves = (
        Curve(label="off", style=0, x=(0.0, 1.0), y=(-0.95, -0.93)),
        Curve(label="both", style=1, x=(0.0, 1.0), y=(low, low)),
    )
    draw_chart(axes, LineChart(x_label="x", y_label="h_min", curves=curves, limit=limit))

    assert axes.get_yscale() == scale
    height = abs(axes.transAxes.inverted().transform(axes.transData.transform((0.0, low)))[1])
    at_limit = abs(axes.transAxes.inverted().transform(axes.transData.transform((0.0, 0.0)))[1])
    assert (abs(height - at_limit) > 0.02) == (scale == "symlog" or low == -0.1)


def test_curves_on_the_limit_alone_have_a_linear_axis() -> None:
    axes = Figure().add_subplot()
    curve = Curve(label="both", style=1, x=(0.0, 1.0), y=(0.0, 0.0))
    draw_chart(axes, LineChart(x_label="x", y_label="y", curves=(curve,), limit=0.0))

    assert axes.get_yscale() == "linear"


def test_marks_are_hollow_where_open_and_square_where_doubtful() -> None:
    axes = Figure().add_subplot()
    curve = Curve(label="both", style=0, x=(0.0, 1.0, 2.0), y=(2.0, 3.0, 4.0), open_at=(1,), doubtful_at=(2,))
    draw_chart(axes, LineChart(x_label="x", y_label="y", curves=(curve,)))
    marks = [line for line in axes.get_lines() if line.get_marker() in {"o", "s"}]
    colour, _ = line_style(0)
    assert [mark.get_marker() for mark in marks] == ["o", "o", "s"]
    assert [mark.get_markerfacecolor() for mark in marks] == [colour, PAPER, colour]


def test_usage_is_printed_without_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 2
    assert "usage" in capsys.readouterr().err
