"""Prints runs side by side."""

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from passafe_services.tools.compare.comparison import ComparedRun, Comparison
from passafe_services.tools.compare.metric_titles import METRIC_TITLES
from passafe_services.tools.compare.run_metrics import RunMetrics


def print_comparison(console: Console, comparison: Comparison, names: list[str]) -> None:
    """Print a table of runs, one column each, with the difference to the first.

    Args:
        console: Where to print.
        comparison: The runs.
        names: Their names.
    """
    table = Table("", *map(escape, names), title=f"aligned by {comparison.align}", title_justify="left")
    runs = comparison.runs
    table.add_row("verdict", *(_verdict(run.metrics) for run in runs))
    table.add_row("mode", *(run.metrics.mode for run in runs))
    for name, title in METRIC_TITLES.items():
        if any(getattr(run.metrics, name) is not None for run in runs):
            table.add_row(title, *(_cell(run, name) for run in runs))
    table.add_row("statuses", *(_statuses(run.metrics) for run in runs))
    table.add_row("position apart, rms", *("" if run.apart is None else f"{run.apart.rms:.4g}" for run in runs))
    table.add_row("position apart, most", *(_most_apart(run) for run in runs))
    console.print(table)


def _verdict(metrics: RunMetrics) -> str:
    return metrics.verdict if metrics.verdict == "holds" else f"[bold red]{metrics.verdict}[/]"


def _cell(run: ComparedRun, name: str) -> str:
    value = getattr(run.metrics, name)
    if value is None:
        return "none"
    difference = run.differences.get(name)
    return f"{value:.4g}" + (f" ({difference:+.3g})" if difference else "")


def _statuses(metrics: RunMetrics) -> str:
    return ", ".join(f"{name} {count}" for name, count in metrics.status_counts.items())


def _most_apart(run: ComparedRun) -> str:
    return "" if run.apart is None else f"{run.apart.largest:.4g} at {run.apart.largest_at_s:.3f} s"
