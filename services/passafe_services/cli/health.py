"""``passafe health``: ask whether the loop of a process does its work, for health checks of containers."""

from pathlib import Path
from time import monotonic_ns
from typing import Annotated, Final

import typer

from passafe_services.cli.failure import run_reporting_errors
from passafe_services.loop.health_report import HealthReport
from passafe_services.loop.process_name import ProcessName

FOLDER_VARIABLE: Final = "PASSAFE_HEALTH"


def health(
    process: Annotated[ProcessName, typer.Argument(metavar="PROCESS", help="Process to ask.")],
    folder: Annotated[
        Path,
        typer.Option(
            metavar="FOLDER", envvar=FOLDER_VARIABLE, help="Folder in which its loop reports: its `--health-folder`."
        ),
    ],
) -> None:
    """Ask whether the loop of a process on this machine does its work; exit with 0 if so, else with 1.

    The answer is what the loop itself reports once a second, so a process that hangs does not pass, also if its web
    server still answers. Healthy is a loop that reported within 3 s, is connected to a router and skips less than half
    of its steps.

    Example: `passafe run filter --health-folder /run/passafe`, then `passafe health filter --folder /run/passafe`
    """
    report = HealthReport.read(folder, process)
    trouble = f"no report in {folder}" if report is None else report.trouble(monotonic_ns())
    typer.echo(f"{process}: {f'unhealthy: {trouble}' if trouble else 'healthy'}")
    raise typer.Exit(1 if trouble else 0)


if __name__ == "__main__":  # a health check starts this, without the imports of the other commands
    app = typer.Typer(pretty_exceptions_enable=False)
    app.command()(health)
    run_reporting_errors(app)
