"""``passafe browse``: show logs and experiments in a page."""

from pathlib import Path
from typing import Annotated

import typer

from passafe_services.cli.errors import OptionError


def browse(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder with logs and experiments.")] = Path("runs"),
    port: Annotated[
        int, typer.Option("--port", metavar="PORT", min=0, max=65535, help="Port of the page; 0 takes a free one.")
    ] = 8080,
) -> None:
    """Show the logs and experiments of a folder in a page, until Ctrl-C.

    The page lists them, reviews and plays a log, compares two, asks what if, and shows the map of a sweep that is
    running or done. The page of `passafe demo` has the same sheets; this needs no running system. It can be opened on
    this host alone.

    Examples:
    - `passafe browse`
    - `passafe browse experiments/delay --port 8090`
    """
    from passafe_dashboard.browsing import browse as serve  # noqa: PLC0415 - a second that others need not wait

    if not folder.is_dir():
        raise OptionError("FOLDER", str(folder), "a folder that exists")
    serve(folder, port, on_ready=lambda address: typer.echo(f"logs at {address}\nend with Ctrl-C"))
