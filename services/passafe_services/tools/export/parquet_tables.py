"""Write the tables of a log as Parquet: one file for each topic, units in the metadata of the columns."""

from contextlib import ExitStack
from pathlib import Path
from typing import Final

import pyarrow as pa
from pyarrow import parquet

from passafe_services.tables.columns import Kind
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.whole_file import whole_output

_TYPES: Final[dict[Kind, pa.DataType]] = {
    "float": pa.float64(),
    "int": pa.int64(),
    "uint": pa.uint64(),
    "bool": pa.bool_(),
    "text": pa.string(),
}


def write_parquet(scan: LogScan, folder: Path) -> list[Path]:
    """Write ``tick.parquet``, ``state.parquet`` and so on; return the files, of topics with messages only.

    The metadata of each file hold ``start_ns``, at which ``time_s`` is zero, and the ``scenario`` as JSON.

    Raises:
        ExportError: A file cannot be written; none is left half-written.
    """
    files = {name: folder / f"{name}.parquet" for name, rows in scan.counts.items() if rows}
    schemas = {name: _schema(scan, scan.layouts[name]) for name in files}
    with ExitStack() as stack:
        writers = {}
        for name, path in files.items():
            unfinished = stack.enter_context(whole_output(path))
            writers[name] = stack.enter_context(parquet.ParquetWriter(unfinished, schemas[name], compression="zstd"))
        for name, rows in scan.blocks():
            schema = schemas[name]
            arrays = [
                pa.array(values, type=field.type) for values, field in zip(zip(*rows, strict=True), schema, strict=True)
            ]
            writers[name].write_batch(pa.record_batch(arrays, schema=schema))
    return list(files.values())


def _schema(scan: LogScan, layout: TableLayout) -> pa.Schema:
    fields = [
        pa.field(column.name, _TYPES[column.kind], metadata={"unit": column.unit} if column.unit else None)
        for column in layout.columns
    ]
    metadata = {"start_ns": str(scan.start_ns)}
    if scan.scenario is not None:
        metadata["scenario"] = scan.scenario.model_dump_json()
    return pa.schema(fields, metadata=metadata)
