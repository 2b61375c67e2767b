"""Write the tables of a log as CSV: one file for each topic, the first line names the columns with their units."""

import csv
from contextlib import ExitStack
from pathlib import Path

from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.whole_file import whole_output


def write_csv(scan: LogScan, folder: Path) -> list[Path]:
    """Write ``tick.csv``, ``state.csv`` and so on; return the files, of topics with messages only.

    Numbers are written so that reading gives back the same; not-a-number is ``nan``.

    Raises:
        ExportError: A file cannot be written; none is left half-written.
    """
    files = {name: folder / f"{name}.csv" for name, rows in scan.counts.items() if rows}
    with ExitStack() as stack:
        writers = {}
        for name, path in files.items():
            unfinished = stack.enter_context(whole_output(path))
            file = stack.enter_context(unfinished.open("w", newline="", encoding="utf-8"))
            writers[name] = csv.writer(file)
            writers[name].writerow(column.heading for column in scan.layouts[name].columns)
        for name, rows in scan.blocks():
            writers[name].writerows(rows)
    return list(files.values())
