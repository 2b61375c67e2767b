"""Write a log for viewers: its own messages, and beside them those of the well-known schemas, with a layout file."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from mcap.well_known import MessageEncoding, SchemaEncoding
from mcap.writer import CompressionType, Writer
from passafe_protocol.codec import file_descriptor_set, schema_name

from passafe_services.log.log_writer import SCENARIO_RECORD
from passafe_services.tables.log_messages import LoggedRow
from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.whole_file import whole_output
from passafe_services.viewer.layout_file import layout_json
from passafe_services.viewer.run_view import RunView
from passafe_services.viewer.view_message import ViewMessage

LAYOUT_SUFFIX: Final = ".layout.json"
"""Of the layout file, in the place of ``.mcap``."""

SEQUENCE_MODULUS: Final = 2**32


def write_foxglove(scan: LogScan, path: Path) -> list[Path]:
    """Write the log and a layout file beside it; return both paths.

    Raises:
        ExportError: A file cannot be written; none is left half-written.
    """
    layout = path.with_suffix(LAYOUT_SUFFIX)
    with whole_output(path) as unfinished, unfinished.open("wb") as stream:
        writer = _ViewWriter(Writer(stream, compression=CompressionType.ZSTD))
        writer.begin(scan)
        view = RunView(scan.scenario, scan.layouts, scan.start_ns)
        for row in scan.rows():
            writer.write_own(row)
            for message in view.views(row):
                writer.write_view(message)
        writer.finish()
    with whole_output(layout) as unfinished:
        unfinished.write_text(layout_json(scan.layouts), encoding="utf-8")
    return [path, layout]


class _ViewWriter:
    """MCAP file with a channel for each key of passafe and each topic of the viewer."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}

    def begin(self, scan: LogScan) -> None:
        """Write the beginning of the file, with the scenario."""
        self._writer.start(library="passafe")
        if scan.scenario is not None:
            self._writer.add_metadata(SCENARIO_RECORD, {"json": scan.scenario.model_dump_json()})

    def write_own(self, row: LoggedRow) -> None:
        """Write a message of passafe as it is."""
        channel = self._channel(row.key, schema_name(row.topic), file_descriptor_set)
        self._add(channel, row.data, row.log_ns, row.header.sequence % SEQUENCE_MODULUS)

    def write_view(self, view: ViewMessage) -> None:
        """Write a message for the viewer."""
        channel = self._channel(view.topic.name, view.topic.schema_name, lambda: view.topic.schema)
        self._add(channel, view.message.SerializeToString(), view.time_ns, 0)

    def finish(self) -> None:
        """Write the end of the file."""
        self._writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated

    def _add(self, channel: int, data: bytes, time_ns: int, sequence: int) -> None:
        self._writer.add_message(channel, log_time=time_ns, data=data, publish_time=time_ns, sequence=sequence)

    def _channel(self, name: str, schema: str, definition: Callable[[], bytes]) -> int:
        found = self._channels.get(name)
        if found is None:
            if schema not in self._schemas:
                self._schemas[schema] = self._writer.register_schema(schema, SchemaEncoding.Protobuf, definition())
            found = self._writer.register_channel(name, MessageEncoding.Protobuf, self._schemas[schema])
            self._channels[name] = found
        return found
