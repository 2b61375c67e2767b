"""Write a log as a bag of ROS 2 with standard messages, stored as MCAP."""

import errno
import os
from pathlib import Path
from typing import Final

from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer

from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.errors import ExportError
from passafe_services.tools.export.ros2_messages import STORE, RosMessage, RosMessages
from passafe_services.tools.export.whole_file import whole_output

VERSION: Final = 9
"""Version of the bag's metadata: that of ROS 2 Iron and later."""

METADATA: Final = "metadata.yaml"
"""File of a bag that names the others."""


def write_ros2(scan: LogScan, folder: Path) -> list[Path]:
    """Write the folder of a bag; return its path. A bag that is there is replaced, and no other folder.

    Raises:
        ExportError: It cannot be written; none is left half-written.
    """
    _require_replaceable(folder)
    place = Path(os.path.realpath(folder))
    converter = RosMessages(scan.scenario)
    with whole_output(folder) as unfinished:
        with Writer(unfinished, version=VERSION, storage_plugin=StoragePlugin.MCAP) as writer:
            connections: dict[str, Connection] = {}
            for row in scan.rows():
                for one in converter.messages(row.header, row.body, row.log_ns):
                    connection = connections.get(one.topic)
                    if connection is None:
                        connection = writer.add_connection(one.topic, one.type_name, typestore=STORE)
                        connections[one.topic] = connection
                    writer.write(connection, row.log_ns, _bytes(one))
        _name_after(unfinished, place)
    return [folder]


def _require_replaceable(folder: Path) -> None:
    """Refuse a folder with anything in it that is not of a bag: it would be lost.

    Raises:
        ExportError: There is something.
    """
    try:
        found = sorted(folder.iterdir()) if folder.exists() else []
        metadata = folder / METADATA
        named = metadata.read_text(encoding="utf-8", errors="replace") if metadata.is_file() else ""
    except OSError as error:
        raise ExportError(folder, error) from error
    others = [each.name for each in found if each != metadata and f" {each.name}\n" not in named]
    if others:
        what = f"it holds {others[0]}, which is not of a bag; allowed a new folder, or a bag, which is replaced"
        raise ExportError(folder, OSError(errno.ENOTEMPTY, what))


def _bytes(one: RosMessage) -> memoryview:
    return STORE.serialize_cdr(one.message, one.type_name)


def _name_after(written: Path, folder: Path) -> None:
    """Give the files of a bag the name of its folder, also in its metadata."""
    metadata = written / METADATA
    metadata.write_text(metadata.read_text().replace(written.name, folder.name))
    for file in written.glob(f"{written.name}*"):
        file.rename(file.with_name(file.name.replace(written.name, folder.name)))
