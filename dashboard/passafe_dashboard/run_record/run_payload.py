"""Turn the record of a run into what its page reads: JSON values and packed arrays."""

from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from passafe_dashboard.number_text import number, signed
from passafe_dashboard.run_record.bucket_table import BucketTable, IntArray
from passafe_dashboard.run_record.collector import RunCollector
from passafe_dashboard.run_record.detail_blocks import DetailBlocks
from passafe_dashboard.run_record.packed_arrays import PackedArrays, Rounding
from passafe_dashboard.run_record.run_events import REVIEW, RunEvent
from passafe_dashboard.run_record.scene_payload import scene_payload

NS_PER_S: Final = 1e9


def run_payload(run: RunCollector, *, label: str) -> dict[str, Any]:
    """Return the record of a finished run for the page.

    Args:
        run: Its record.
        label: What a page of several runs calls it.
    """
    packed = PackedArrays()
    tables = {
        "ticks": _table(packed, run.ticks, run.tick_details),
        "states": _table(packed, run.states, run.state_details),
        "counts": _counts(packed, run),
    }
    unit = run.scenario.plant.robot_model.position_unit
    start_s, end_s = extent_s(run)
    return {
        "label": label,
        "start_s": start_s,
        "end_s": end_s,
        "tables": tables,
        "scene": scene_payload(run.layout, unit),
        "packed": packed.text(),
    }


def extent_s(run: RunCollector) -> tuple[float, float]:
    """Return plant times of begin and end of a run, s."""
    ends = [
        (table.start_ns, table.start_ns + table.count.size * table.width_ns)
        for table in (run.states, run.ticks)
        if table.count.size
    ]
    if not ends:
        return 0.0, 1.0
    return max(0.0, min(start for start, _ in ends) / NS_PER_S), max(end for _, end in ends) / NS_PER_S


def run_events(run: RunCollector) -> list[RunEvent]:
    """Return all that happened, in order of time: published events, and stretches in which something was wrong."""
    return sorted([*run.events.events(run.clock), *_found(run)])


def _found(run: RunCollector) -> Iterator[RunEvent]:
    for i, (barrier, below) in enumerate(zip(run.layout.barriers, run.below_zero, strict=True)):
        for span in below.spans:
            depth = f"lowest {run.layout.h_text(i, span.worst)}"
            words = f"{barrier.name} violated {_for(span.start_ns, span.end_ns)}, {depth} at {_time(span.worst_ns)}"
            yield RunEvent(span.start_ns / NS_PER_S, "error", REVIEW, words)
    for status, fallback in run.fallbacks.items():
        for span in fallback.spans:
            words = f"fallback {status.name} {_for(span.start_ns, span.end_ns)}"
            yield RunEvent(span.start_ns / NS_PER_S, "warning", REVIEW, words)
    for phase, missing in run.phases.items():
        what = {"HOLDING": "input missing, the last one held", "FAIL_SAFE": "plant in its fail-safe"}[phase.name]
        for span in missing.spans:
            yield RunEvent(span.start_ns / NS_PER_S, "warning", REVIEW, f"{what} {_for(span.start_ns, span.end_ns)}")


def _for(start_ns: int, end_ns: int) -> str:
    return f"for {number((end_ns - start_ns) / NS_PER_S, 3)} s" if end_ns > start_ns else "at one sample"


def _time(t_ns: int) -> str:
    return signed(f"{t_ns / NS_PER_S:.3f} s")


def _table(packed: PackedArrays, table: BucketTable, details: DetailBlocks) -> dict[str, Any]:
    names = (*table.envelopes, *table.firsts)
    blocks = [
        {
            "start_s": int(block.t_ns[0]) / NS_PER_S,
            "count": int(block.t_ns.size),
            "times": packed.times(block.t_ns),
            "columns": {name: packed.floats(row) for name, row in zip(names, block.values, strict=True)},
        }
        for block in details.kept
    ]
    return {"overview": None if details.complete else _overview(packed, table), "blocks": blocks}


def _overview(packed: PackedArrays, table: BucketTable) -> dict[str, Any]:
    filled = np.flatnonzero(table.count)
    starts = table.start_ns + filled * table.width_ns
    return {
        "start_s": int(starts[0]) / NS_PER_S if starts.size else 0.0,
        "count": int(starts.size),
        "width_s": table.width_ns / NS_PER_S,
        "times": packed.times(starts),
        "low": {
            name: packed.floats(row[filled], Rounding.DOWN)
            for name, row in zip(table.envelopes, table.low, strict=True)
        },
        "high": {
            name: packed.floats(row[filled], Rounding.UP) for name, row in zip(table.envelopes, table.high, strict=True)
        },
        "first": {name: packed.floats(row[filled]) for name, row in zip(table.firsts, table.first, strict=True)},
    }


def _counts(packed: PackedArrays, run: RunCollector) -> dict[str, Any]:
    """Return counts a second, on the axis of plant time."""
    counts = run.counts
    rows = {name: counts.per_s(name) for name in counts.names}
    stretches = max((row.size for row in rows.values()), default=0)
    starts: IntArray = counts.start_ns + np.arange(stretches, dtype=np.int64) * counts.width_ns
    plant_s = run.clock.plant_s(starts)
    return {
        "overview": {
            "width_s": counts.width_ns / NS_PER_S,
            "count": stretches,
            "start_s": float(plant_s[0]) if stretches else 0.0,
            "times": packed.times(np.round(plant_s * NS_PER_S).astype(np.int64)),
            "low": {},
            "high": {},
            "first": {name: packed.floats(row) for name, row in rows.items()},
        },
        "blocks": [],
    }
