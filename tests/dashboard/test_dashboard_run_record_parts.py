"""Parts of a run's record: stretches sample by sample, counts, spans, the plant's clock."""

import numpy as np
import pytest
from passafe_dashboard.run_record.count_table import CountTable
from passafe_dashboard.run_record.detail_blocks import DetailBlock, DetailBlocks
from passafe_dashboard.run_record.plant_timeline import PlantTimeline
from passafe_dashboard.run_record.spans import Span, SpanRecorder

S = 1_000_000_000


def block(number: int, low: float) -> DetailBlock:
    return DetailBlock(np.arange(10) + 10 * number, np.vstack([np.full(10, low), np.arange(10.0)]))


def starts(blocks: DetailBlocks) -> list[int]:
    return [int(kept.t_ns[0]) // 10 for kept in blocks.kept]


def test_stretches_with_extremes_and_asked_ones_stay() -> None:
    blocks = DetailBlocks(lowest=[0], highest=[1], most=30)
    for number in range(10):
        blocks.add(block(number, -5.0 if number == 4 else float(number)), asked=number == 6)
    assert {4, 6} <= set(starts(blocks))
    assert len(starts(blocks)) == 3
    assert not blocks.complete


def test_a_new_extreme_frees_the_stretch_of_the_old_one() -> None:
    blocks = DetailBlocks(lowest=[0], highest=[], most=10)
    for number in range(5):
        blocks.add(block(number, -float(number)))
    assert starts(blocks) == [4]


def test_all_of_a_short_run_stays() -> None:
    blocks = DetailBlocks(lowest=[0], highest=[], most=100)
    for number in range(10):
        blocks.add(block(number, 0.0))
    assert blocks.complete
    assert starts(blocks) == list(range(10))


def test_counts_add_up_however_wide_their_stretches() -> None:
    counts = CountTable(width_ns=S, most=8)
    for second in range(100):
        counts.add("drops", second * S + np.arange(second % 3))
    counts.add("copies", np.array([50 * S]))
    assert counts.counts("drops").sum() == 99
    assert counts.counts("copies").sum() == 1
    assert counts.counts("drops").size <= 8
    assert counts.names == ("drops", "copies")


def test_rate_of_an_even_stream_is_even_to_both_ends() -> None:
    counts = CountTable(width_ns=S, most=8)
    counts.add("ticks", np.arange(300_000_000, 5_800_000_000, 10_000_000))
    assert counts.per_s("ticks") == pytest.approx(100, rel=0.03)


def test_a_span_over_several_blocks_is_one() -> None:
    spans = SpanRecorder()
    h = np.array([1.0, -1.0, -3.0, -2.0, 1.0, -1.0])
    for part in (slice(0, 2), slice(2, 4), slice(4, 6)):
        spans.add(np.arange(6)[part], h[part] < 0, h[part])
    assert spans.count == 2
    assert spans.spans == [Span(1, 3, -3.0, 2), Span(5, 5, -1.0, 5)]


def test_of_many_spans_the_first_and_the_worst_stay() -> None:
    spans = SpanRecorder(most=3)
    for number, depth in enumerate((1.0, 2.0, 9.0, 3.0, 5.0)):
        spans.add(np.array([number]), np.array([True]), np.array([-depth]))
        spans.add(np.array([number]), np.array([False]), np.array([1.0]))
    assert spans.count == 5
    assert [span.worst for span in spans.spans] == [-1.0, -9.0, -5.0]


def test_wall_times_become_plant_times() -> None:
    clock = PlantTimeline()
    plant_ns = np.arange(0, 10 * S, S // 100)
    clock.add(plant_ns + 1_000 * S, plant_ns)
    walls = np.array([999, 1_000, 1_005, 1_011]) * S
    assert clock.plant_s(walls) == pytest.approx([-1, 0, 5, 11], abs=1e-6)
    assert PlantTimeline().plant_s(walls).tolist() == [0, 0, 0, 0]
