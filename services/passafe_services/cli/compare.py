"""``passafe compare``: set runs side by side."""

from itertools import chain
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from passafe_services.cli.comparison_table import print_comparison
from passafe_services.cli.errors import OptionError
from passafe_services.cli.options import writable_folder
from passafe_services.cli.output_files import require_separate
from passafe_services.log.log_files import files_of
from passafe_services.tools.compare.alignment import KINDS
from passafe_services.tools.compare.comparison import Comparison
from passafe_services.tools.compare.run_metrics import ReviewedRun
from passafe_services.tools.review.run_log import RunLog

LEAST_RUNS = 2

AlignOption = Annotated[
    str,
    typer.Option(
        "--align",
        metavar="MOMENT",
        help=f"Moment that counts as zero in each run: start, first-input, or event:KIND with {', '.join(KINDS)}.",
    ),
]
SvgOption = Annotated[Path | None, typer.Option("--svg", metavar="FILE", help="Draw the runs over one another.")]
HtmlOption = Annotated[Path | None, typer.Option("--html", metavar="FILE", help="Write the same as a page.")]


def compare(
    runs: Annotated[list[Path], typer.Argument(metavar="LOG LOG…", help="MCAP logs; the first is the reference.")],
    align: AlignOption = "start",
    svg: SvgOption = None,
    html: HtmlOption = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Set runs side by side: verdicts, margins, ages, what was held back, and how far the robots are apart.

    Each log is reviewed as by `passafe review`. Exits with 0 whatever the verdicts are.

    Examples:
    - `passafe compare runs/good.mcap runs/bad.mcap`
    - `passafe compare a.mcap b.mcap c.mcap --align event:stop --svg overlay.svg`
    """
    if len(runs) < LEAST_RUNS:
        raise OptionError("LOG", f"{len(runs)} log", "two or more")
    require_separate({"--svg": svg, "--html": html}, chain.from_iterable(map(files_of, runs)))
    reviewed = [ReviewedRun.of(RunLog.read(path)) for path in runs]
    comparison = Comparison.of(reviewed, align)
    names = [path.stem for path in runs]
    draw_overlay(reviewed, comparison, names, svg=svg, html=html)
    if json:
        typer.echo(comparison.model_dump_json(indent=2))
    else:
        print_comparison(Console(highlight=False), comparison, names)


def draw_overlay(
    runs: list[ReviewedRun],
    comparison: Comparison,
    names: list[str],
    *,
    svg: Path | None,
    html: Path | None,
    notes: tuple[str, ...] = (),
) -> None:
    """Draw runs over one another into files.

    Args:
        runs: The runs.
        comparison: Their comparison.
        names: Their names.
        svg: Picture to write, if any.
        html: Page to write, if any.
        notes: What picture and page have to say.
    """
    origins = [run.origin_s for run in comparison.runs]
    if svg is not None:
        from passafe_dashboard.comparison_picture import comparison_picture  # noqa: PLC0415 - a second others need not wait

        writable_folder(svg.parent, "--svg")
        svg.write_text(comparison_picture([run.log for run in runs], origins, names, notes), encoding="utf-8")
    if html is not None:
        _write_page(html, runs, origins, names, notes)


def _write_page(
    html: Path, runs: list[ReviewedRun], origins: list[float], names: list[str], notes: tuple[str, ...]
) -> None:
    from passafe_dashboard.run_report import overlay_report, report_runs, write_report  # noqa: PLC0415 - likewise

    if html.is_dir():
        raise OptionError("--html", f"{html}, a folder", "a file")
    writable_folder(html.parent, "--html")
    shown = report_runs(runs, names, origins)
    write_report(html, overlay_report(shown, title=" and ".join(names), notes=notes))
