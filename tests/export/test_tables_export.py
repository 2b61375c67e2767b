import csv
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from passafe_services.tables.run_tables import RunTables
from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.csv_tables import write_csv
from passafe_services.tools.export.errors import ExportError
from passafe_services.tools.export.parquet_tables import write_parquet
from passafe_services.tools.export.whole_file import whole_output
from pyarrow import parquet
from small_log import small_log


def test_csv_has_a_file_for_each_topic_with_units(tmp_path: Path) -> None:
    scan = LogScan.of(small_log(tmp_path / "run.mcap"))

    files = write_csv(scan, tmp_path / "tables")

    assert sorted(path.name for path in files) == ["event.csv", "health.csv", "state.csv", "tick.csv"]
    assert sorted(path.name for path in (tmp_path / "tables").iterdir()) == sorted(path.name for path in files)
    with (tmp_path / "tables" / "state.csv").open(newline="") as file:
        head, *rows = csv.reader(file)
    assert {"x_1 [m]", "x_3 [m/s]", "u_1 [m/s²]", "energy_in_j", "plant_ns"} <= set(head)
    assert [row[head.index("x_1 [m]")] for row in rows] == ["0.0", "1.0", "2.0", "3.0"]


def test_csv_gives_back_every_number(tmp_path: Path) -> None:
    path = small_log(tmp_path / "run.mcap")
    run = RunTables.read(path)
    write_csv(LogScan.of(path), tmp_path)

    frame = pd.read_csv(tmp_path / "tick.csv", keep_default_na=False, na_values=["nan"])

    for name, heading in zip(run.ticks.columns, frame.columns, strict=True):
        read, was = frame[heading].to_numpy(), run.ticks[name]
        assert heading.split(" ")[0] == name
        assert np.array_equal(read.astype(was.dtype), was, equal_nan=was.dtype == np.float64), name


def test_parquet_gives_back_every_number_and_unit(tmp_path: Path) -> None:
    path = small_log(tmp_path / "run.mcap")
    run = RunTables.read(path)
    write_parquet(LogScan.of(path), tmp_path)

    table = parquet.read_table(tmp_path / "tick.parquet")

    for name, was in run.ticks.columns.items():
        read = table[name].to_numpy()
        assert np.array_equal(read.astype(was.dtype), was, equal_nan=was.dtype == np.float64), name
    assert table.schema.field("barrier_disk_psi_1").metadata == {b"unit": "m²/s".encode()}
    assert table.schema.metadata[b"start_ns"] == str(run.start_ns).encode()
    assert b'"notomista-cai-2020"' in table.schema.metadata[b"scenario"]


def test_output_that_is_not_finished_leaves_what_was_there(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    path.write_text("before")

    def interrupted() -> None:
        with whole_output(path) as unfinished:
            unfinished.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()

    assert path.read_text() == "before"
    assert [one.name for one in tmp_path.iterdir()] == ["table.csv"]


def test_a_finished_folder_replaces_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "bag"
    path.mkdir()
    (path / "old").touch()

    with whole_output(path) as unfinished:
        unfinished.mkdir()
        (unfinished / "new").touch()

    assert [one.name for one in path.iterdir()] == ["new"]


def test_a_full_or_closed_place_is_a_typed_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()

    with pytest.raises(ExportError, match="cannot be written"):
        write_csv(LogScan.of(small_log(tmp_path / "run.mcap")), tmp_path / "file" / "tables")
