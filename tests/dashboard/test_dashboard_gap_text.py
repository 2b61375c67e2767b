import pytest
from passafe_dashboard.live.barrier_gaps import Gap
from passafe_dashboard.live.gap_text import barrier_words, distance_text, is_at_limit


@pytest.mark.parametrize(
    ("distance", "unit", "text"),
    [
        (0.04, "m", "4.0 cm"),
        (-0.24, "m", "24 cm"),
        (1.234, "m", "1.2 m"),
        (12.34, "m", "12 m"),
        (0.0042, "m", "4.2 mm"),
        (-4.39e-14, "m", "0 mm"),
        (0.1, "rad", "5.7°"),
        (0.5, "rad/s", "29°/s"),
        (0.12, "m/s", "0.12 m/s"),
        (3e-9, "", "0"),
    ],
)
def test_distances_are_written_as_people_read_them(distance: float, unit: str, text: str) -> None:
    assert distance_text(distance, unit) == text


@pytest.mark.parametrize("unit", ["m", "rad", "rad/s", "m/s", ""])
def test_what_is_shown_as_0_is_at_its_limit(unit: str) -> None:
    assert [is_at_limit(distance, unit) for distance in (0.0, -1e-5, 4e-5, 0.1, -2.0)] == [True] * 3 + [False] * 2


@pytest.mark.parametrize(
    ("towards", "kind", "unit", "words"),
    [
        ((-1.0, 0.0), "half-plane", "m", "the wall on the left"),
        ((0.6, 0.8), "disk-keep-out", "m", "“table” above"),
        ((0.0, -1.0), "disk-keep-out", "m", "“table” below"),
        ((1.0, 0.0), "keep-apart", "m", "the other robot on the right"),
        ((1.0, 0.0), "speed-limit", "m/s", "the speed limit"),
        ((0.0, 0.0), "coordinate-limits", "rad", "“table”"),
    ],
)
def test_barriers_are_called_as_people_do(towards: tuple[float, float], kind: str, unit: str, words: str) -> None:
    gap = Gap(name="table", distance=1.0, unit=unit, towards=towards, point=0, pulls=(towards,))
    assert barrier_words(gap, kind) == words
