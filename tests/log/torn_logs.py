"""Logs of known contents, to tear, and what readers find in them."""

from pathlib import Path

from mcap.reader import make_reader
from passafe_protocol.codec import encode
from passafe_protocol.messages import Event, Header
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.record_scan import IntactRecord, scan_records

WALL_NS = 1_763_800_000_000_000_000
MS = 1_000_000


def write_log(path: Path, *, flushes: int = 5, between: int = 10) -> list[int]:
    """Write a log of two channels; return the size of the file after every flush."""
    sizes = []
    with LogWriter(path, {"driver": {"kind": "live"}}) as log:
        for k in range(flushes * between):
            source = ("plant", "filter")[k % 2]
            header = Header(source, 1, k // 2, 0, 0, 0, WALL_NS + k * MS)
            data = encode(header, Event("info", f"number {k}"))
            log.write(f"passafe/robot/{source}/event", data, sequence=k // 2, wall_ns=header.wall_ns)
            if (k + 1) % between == 0:
                log.flush()
                sizes.append(path.stat().st_size)
    return sizes


def contents(path: Path) -> list[tuple[str, str, int, int, bytes]]:
    """Every message as the standard reader gives it."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        return [
            (channel.topic, schema.name if schema else "", message.log_time, message.sequence, message.data)
            for schema, channel, message in reader.iter_messages()
        ]


def metadata(path: Path) -> dict[str, dict[str, str]]:
    with path.open("rb") as stream:
        return {record.name: record.metadata for record in make_reader(stream).iter_metadata()}


def end_of_first(kind: int, path: Path) -> int:
    """Return the offset after the first record of a kind."""
    with path.open("rb") as stream:
        records = [each for each in scan_records(stream, path.stat().st_size) if isinstance(each, IntactRecord)]
    return next(each.end for each in records if each.opcode == kind)
