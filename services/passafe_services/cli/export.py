"""``passafe export``: write a log as files that other tools read."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Annotated, Final, NamedTuple

import typer

from passafe.errors import MissingPackageError
from passafe_services.cli.errors import OptionError
from passafe_services.cli.output_files import require_separate
from passafe_services.log.log_files import files_of
from passafe_services.tables.scan import LogScan


class Format(NamedTuple):
    """A format of ``passafe export``.

    Attributes:
        option: The option that asks for it.
        module: Module with the function that writes it, loaded only where it is asked for.
        function: The function: of a scan and a path, returning the paths written.
        extra: Extra of passafe that installs what it needs.
    """

    option: str
    module: str
    function: str
    extra: str


CSV: Final = Format("--csv", "csv_tables", "write_csv", "run")
PARQUET: Final = Format("--parquet", "parquet_tables", "write_parquet", "service")
FOXGLOVE: Final = Format("--foxglove", "foxglove_log", "write_foxglove", "foxglove")
ROS2: Final = Format("--ros2", "ros2_bag", "write_ros2", "ros2")


def export(
    log: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log, of a live or simulated run, whole or torn.")],
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FOLDER", help="Write a CSV file for each topic into this folder.")
    ] = None,
    parquet: Annotated[
        Path | None, typer.Option("--parquet", metavar="FOLDER", help="Write a Parquet file for each topic, likewise.")
    ] = None,
    foxglove: Annotated[
        Path | None,
        typer.Option(
            "--foxglove",
            metavar="FILE",
            help="Write an MCAP file for viewers, with scene, poses, log lines and named numbers; a layout beside it.",
        ),
    ] = None,
    ros2: Annotated[
        Path | None,
        typer.Option("--ros2", metavar="FOLDER", help="Write a ROS 2 bag of standard messages: this folder."),
    ] = None,
) -> None:
    """Write a log as files that other tools read: tables with a column for each number that has a name.

    Files of the same names are replaced. Of a torn log everything that can be read is written.

    Examples:
    - `passafe export runs/bad.mcap --csv tables`
    - `passafe export runs/bad.mcap --foxglove views/bad.mcap`
    - `passafe export runs/bad.mcap --ros2 bags/bad`
    """
    wanted = [(CSV, csv), (PARQUET, parquet), (FOXGLOVE, foxglove), (ROS2, ros2)]
    asked = [(kind, path) for kind, path in wanted if path is not None]
    if not asked:
        raise OptionError("format", "none", ", ".join(kind.option for kind, _ in wanted))
    require_separate({FOXGLOVE.option: foxglove}, files_of(log))
    writers = [(_writer(kind), path) for kind, path in asked]
    scan = LogScan.of(log)
    for write, path in writers:
        for written in write(scan, path):
            typer.echo(str(written))
    if scan.messages.tear:
        typer.echo(f"the log is torn: {scan.messages.tear}", err=True)
    for topic, number in scan.messages.refused.items():
        typer.echo(f"left out: {number} messages of {topic} that do not decode", err=True)


def _writer(kind: Format) -> Callable[[LogScan, Path], list[Path]]:
    try:
        module = import_module(f"passafe_services.tools.export.{kind.module}")
    except ModuleNotFoundError as error:
        raise MissingPackageError.of(error, kind.extra) from error
    write: Callable[[LogScan, Path], list[Path]] = getattr(module, kind.function)
    return write
