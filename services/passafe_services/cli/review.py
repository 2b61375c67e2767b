"""``passafe review``: judge a run from its log."""

from pathlib import Path
from typing import Annotated

import typer

from passafe_services.cli.options import writable_folder
from passafe_services.cli.verdict import exit_code, print_verdict
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict


def review(
    run: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log, of a live or simulated run, whole or torn.")],
    html: Annotated[
        Path | None, typer.Option("--html", metavar="FILE", help="Write an HTML report to this file.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the verdict as one JSON object.")] = False,
) -> None:
    """Judge a run from its log.

    Barriers and power margin are recomputed from the plant's states alone, between samples too; filter telemetry is
    not trusted. Exits with 0 only if every required property holds.

    Examples:
    - `passafe review runs/bad.mcap --html report.html`
    - `passafe review runs/bad.mcap --json`
    """
    log = RunLog.read(run)
    evaluator = CoreEvaluator(log.identity.scenario)
    verdict = Verdict.of(log, evaluator)
    if html is not None:
        from passafe_dashboard.run_report import render_report  # noqa: PLC0415 - a second that other reviews need not wait

        writable_folder(html.parent, "--html")
        html.write_text(render_report(log, evaluator, verdict), encoding="utf-8")
    if json:
        typer.echo(verdict.model_dump_json(indent=2))
    else:
        print_verdict(verdict, run)
    raise typer.Exit(exit_code(verdict))
