"""Describe the charts of a run in words, for readers who cannot see them."""

import numpy as np

from passafe_dashboard.number_text import number, signed
from passafe_dashboard.run_series import RunSeries


def descriptions(series: RunSeries) -> dict[str, str]:
    """Return the description of each chart of a run, by the chart's name."""
    names = ", ".join(barrier.name for barrier in series.barriers if barrier.outline is not None)
    shown = series.lowest_barriers
    lowest_h = "; ".join(
        f"{series.barriers[i].name} lowest sample {number(h.min().item())} at {series.times_s[h.argmin()]:.3f} s"
        for i, h in ((i, series.h[i]) for i in shown)
    )
    if len(shown) < len(series.barriers):
        rest = np.delete(series.h, shown, axis=0)
        lowest_h += f"; {len(rest)} others not shown, none below {number(rest.min().item())}"
    worst = series.power_margin_w.argmin()
    margin = number(series.power_margin_w[worst].item())
    return {
        "plane": f"{_paths(series)}. Obstacles: {names or 'none'}.",
        "h": f"Barrier values over plant time with the line h = 0: {lowest_h}.",
        "power_margin": (
            f"Power margin over plant time with the line 0: lowest sample {margin} W at {series.times_s[worst]:.3f} s."
        ),
        "status": "A row for each filter status; a bar where the filter's ticks had it.",
    }


def _paths(series: RunSeries) -> str:
    paths = []
    for point in range(series.points):
        p1, p2 = series.position(point)
        which = f" {point + 1}" if series.points > 1 else ""
        ends = f"({p1[0]:.3f}, {p2[0]:.3f}) m to ({p1[-1]:.3f}, {p2[-1]:.3f}) m"
        paths.append(signed(f"Path of the robot{which} from {ends}"))
    return ". ".join(paths)
