"""Grid, shares, table and picture of the atlas."""

import csv
import io
import xml.etree.ElementTree as ET
from math import inf, nan

import numpy as np
import pytest
from closed_form_designs import mass
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from passafe_dashboard.feasibility_picture import atlas_picture, categories_of, draw_atlas
from passafe_services.tools.feasibility.atlas import Atlas, Counts, SampleSummary
from passafe_services.tools.feasibility.constraint_feasibility import ConstraintFeasibility, Findings
from passafe_services.tools.feasibility.errors import FeasibilityError
from passafe_services.tools.feasibility.grid import Grid, GridCoordinate
from passafe_services.tools.feasibility.share import Share, random_states
from scipy.stats import binomtest

SVG = "{http://www.w3.org/2000/svg}"


def grid(cells: int = 8) -> Grid:
    across, up = GridCoordinate(index=0, low=-1.0, high=3.0), GridCoordinate(index=1, low=-4.0, high=4.0)
    return Grid(across=across, up=up, fixed=(9.0, 9.0), cells=cells)


@pytest.fixture(scope="module")
def atlas() -> Atlas:
    """One wall, some of whose protected states ask for more than the brakes give."""
    found = ConstraintFeasibility(mass(((1.0,), 0.0), ((0.3,), 0.0), input_bound=0.5)).at(grid().states())
    return Atlas(scenario="one-wall", grid=grid(), plant_time_s=0.0, found=found)


def test_a_cell_stands_for_its_centre() -> None:
    states = Grid(
        across=GridCoordinate(index=2, low=0.0, high=2.0),
        up=GridCoordinate(index=0, low=10.0, high=14.0),
        fixed=(7.0, 8.0, 9.0),
        cells=2,
    ).states()

    assert states.T.tolist() == [[11.0, 8.0, 0.5], [11.0, 8.0, 1.5], [13.0, 8.0, 0.5], [13.0, 8.0, 1.5]]


@pytest.mark.parametrize(("low", "high"), [(1.0, 1.0), (2.0, 1.0), (0.0, inf), (nan, 1.0)])
def test_an_empty_range_is_refused(low: float, high: float) -> None:
    with pytest.raises(FeasibilityError, match="range of x3"):
        GridCoordinate(index=3, low=low, high=high)


@pytest.mark.parametrize(
    ("first", "second", "cells", "named"),
    [
        (0, 2, 5, "x0 to x1"),
        (0, 0, 5, "two different"),
        (-1, 0, 5, "x0 to x1"),
        (0, 1, 0, "cells"),
        (0, 1, 1001, "1000"),
    ],
)
def test_a_grid_over_nothing_is_refused(first: int, second: int, cells: int, named: str) -> None:
    with pytest.raises(FeasibilityError, match=named):
        Grid(
            across=GridCoordinate(index=first, low=0.0, high=1.0),
            up=GridCoordinate(index=second, low=0.0, high=1.0),
            fixed=(0.0, 0.0),
            cells=cells,
        )


@pytest.mark.parametrize(("kept", "of"), [(0, 10), (10, 10), (37, 120), (9999, 10000)])
def test_the_interval_is_wilson_s(kept: int, of: int) -> None:
    share, expected = Share.counted(kept, of), binomtest(kept, of).proportion_ci(0.95, method="wilson")

    assert (share.low, share.high) == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert (share.kept, share.of) == (kept, of)


def test_a_share_of_nothing_may_be_anything() -> None:
    assert Share.counted(0, 0) == Share(kept=0, of=0, low=0.0, high=1.0)


def test_a_seed_decides_all_states_and_they_fill_their_box() -> None:
    low, high = (-1.0, 0.0, 5.0), (1.0, 0.0, 6.0)
    states = random_states(low, high, 400, 3)

    assert np.array_equal(states, random_states(low, high, 400, 3))
    assert not np.array_equal(states, random_states(low, high, 400, 4))
    assert states.shape == (3, 400)
    assert states.min(axis=1) == pytest.approx(low, abs=0.02)
    assert states.max(axis=1) == pytest.approx(high, abs=0.02)


def test_the_table_has_one_row_a_cell(atlas: Atlas) -> None:
    file = io.StringIO()
    atlas.write_csv(file)
    rows = list(csv.DictReader(io.StringIO(file.getvalue())))

    assert len(rows) == 64
    assert [float(row["x0"]) for row in rows[:8]] == pytest.approx(np.arange(-0.75, 3.0, 0.5))
    assert {row["x1"] for row in rows[:8]} == {"-3.5"}
    for row in rows:
        position, speed = float(row["x0"]), float(row["x1"])
        assert int(row["inside"]) == (position >= 0 and speed + 2 * position >= 0)
        assert int(row["hard_kept"]) == (float(row["hard_margin"]) >= 0)
    assert sum(int(row["inside"]) for row in rows) == Counts.of(atlas.found).inside


def test_sums_count_what_is_inside_only(atlas: Atlas) -> None:
    counts = atlas.summary(None).slice
    position, speed = atlas.found.states
    inside = (position >= 0) & (speed + 2 * position >= 0)
    kept = inside & (4 * speed + 4 * position >= -0.5)

    assert (counts.states, counts.inside, counts.hard) == (64, inside.sum(), kept.sum())
    assert 0 < counts.hard < counts.inside
    sample = SampleSummary.of(atlas.found, (0.0, 0.0), (1.0, 1.0), 5)
    assert (sample.inside.of, sample.hard.of, sample.passive.of) == (64, counts.inside, counts.inside)
    assert sample.hard.kept == counts.hard
    assert "do not imply" in atlas.summary(sample).limitation


def test_every_cell_gives_one_answer() -> None:
    """In the order of the questions: the first that is answered with no."""
    h = np.array([-1.0, 0.5, 1.0, 1.0, 1.0, nan])
    found = Findings(
        states=np.zeros((2, 6)),
        h=h,
        protecting=np.array([-1.0, -0.5, 0.0, 1.0, 1.0, nan]),
        hard_margin=np.array([-1.0, 1.0, -1.0, 1.0, 1.0, 1.0]),
        passive_margin=np.array([-1.0, -1.0, -2.0, -1.0, -1e-7, 1.0]),
        tolerance=1e-6,
        unsettled=np.zeros(6, dtype=np.bool_),
    )
    masks = np.array([mask for _, mask in categories_of(found)])

    assert masks.sum(axis=0).tolist() == [1] * 6
    assert masks.argmax(axis=0).tolist() == [0, 1, 2, 3, 4, 0]


def test_every_cell_is_drawn_in_the_colour_of_its_answer(atlas: Atlas) -> None:
    axes = Figure().add_subplot()
    draw_atlas(axes, atlas, across="x0", up="x1", same_scale=False)
    [image] = axes.get_images()
    colours = image.to_rgba(image.get_array())[..., :3].reshape(64, 3)

    for answer, mask in categories_of(atlas.found):
        assert np.allclose(colours[mask], to_rgb(answer.colour), atol=1e-6)
    assert (image.origin, list(image.get_extent())) == ("lower", [-1.0, 3.0, -4.0, 4.0])


def test_picture_names_every_category_and_has_a_description(atlas: Atlas) -> None:
    text = atlas_picture(atlas, across="x0 (position)", up="x1 (velocity)", same_scale=False)
    root = ET.fromstring(text)  # noqa: S314 - our own text
    words = [element.text for element in root.iter(f"{SVG}text")]

    labels = [answer.label for answer, _ in categories_of(atlas.found)]
    assert len(set(labels)) == 5
    for word in [*labels, "x0 (position)", "x1 (velocity)"]:
        assert word in words
    [description] = root.findall(f"{SVG}desc")
    assert "of 64 cells" in (description.text or "")
    assert "do not imply" in (description.text or "")
    assert text == atlas_picture(atlas, across="x0 (position)", up="x1 (velocity)", same_scale=False)


@pytest.mark.parametrize(("same_scale", "aspect"), [(True, 1.0), (False, "auto")])
def test_positions_have_one_scale(atlas: Atlas, same_scale: bool, aspect: object) -> None:
    axes = Figure().add_subplot()
    draw_atlas(axes, atlas, across="a", up="b", same_scale=same_scale)
    assert axes.get_aspect() == aspect
