"""Put into text how two runs compare, metric by metric."""

from typing import NamedTuple

from passafe_services.tools.compare.comparison import ComparedRun, Comparison
from passafe_services.tools.compare.metric_titles import METRIC_TITLES

from passafe_dashboard.number_text import number, signed


class ComparisonRow(NamedTuple):
    """One line of the table of a comparison, as text.

    Attributes:
        title: Title of the metric.
        values: Its value in each run.
        difference: Its value in the last run minus that in the first; empty for none.
    """

    title: str
    values: tuple[str, ...]
    difference: str


def comparison_rows(comparison: Comparison) -> list[ComparisonRow]:
    """Return the metrics that at least one run has, and how far the robots are apart."""
    runs = comparison.runs
    rows = [
        ComparisonRow(title, tuple(_value(run, name) for run in runs), _difference(runs[-1], name))
        for name, title in METRIC_TITLES.items()
        if any(getattr(run.metrics, name) is not None for run in runs)
    ]
    apart = runs[-1].apart
    if apart is not None:
        nothing = ("",) * len(runs)
        rows.append(ComparisonRow("positions apart, rms", nothing, number(apart.rms, 3)))
        most = f"{number(apart.largest, 3)} at {signed(f'{apart.largest_at_s:.3f} s')}"
        rows.append(ComparisonRow("positions apart, most", nothing, most))
    return rows


def _value(run: ComparedRun, name: str) -> str:
    value = getattr(run.metrics, name)
    return "none" if value is None else number(value, 4)


def _difference(run: ComparedRun, name: str) -> str:
    found = run.differences.get(name)
    if not found:
        return ""
    text = number(found, 3)
    return text if found < 0 else f"+{text}"
