"""Write a log as a bag of ROS 2 with standard messages, stored as MCAP."""

from pathlib import Path
from typing import Final

from rosbags.interfaces import Connection
from rosbags.rosbag2 import StoragePlugin, Writer

from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.ros2_messages import STORE, RosMessage, RosMessages
from passafe_services.tools.export.whole_file import whole_output

VERSION: Final = 9
"""Version of the bag's metadata: that of ROS 2 Iron and later."""


def write_ros2(scan: LogScan, folder: Path) -> list[Path]:
    """Write the folder of a bag; return its path. An existing folder is replaced.

    Raises:
        ExportError: It cannot be written; none is left half-written.
    """
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
        _name_after(unfinished, folder)
    return [folder]


def _bytes(one: RosMessage) -> memoryview:
    return STORE.serialize_cdr(one.message, one.type_name)


def _name_after(written: Path, folder: Path) -> None:
    """Give the files of a bag the name of its folder, also in its metadata."""
    metadata = written / "metadata.yaml"
    metadata.write_text(metadata.read_text().replace(written.name, folder.name))
    for file in written.glob(f"{written.name}*"):
        file.rename(file.with_name(file.name.replace(written.name, folder.name)))
