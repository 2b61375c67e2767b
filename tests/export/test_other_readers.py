"""Readers that are not ours read a log: MCAP's own in Python, one in JavaScript, and one of ROS 2 bags."""

import json
import shutil
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from passafe_services.tables.run_tables import RunTables
from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.foxglove_log import write_foxglove
from passafe_services.tools.export.ros2_bag import write_ros2
from rosbags.highlevel import AnyReader
from small_log import LARGE, WALL_NS, small_log

READER = Path(__file__).with_name("other_readers")
PACKAGES = Path(__file__).parents[2] / ".build" / "other-readers"


@pytest.fixture(scope="module")
def javascript() -> Path:
    """Return the script beside its packages, which are installed once."""
    if shutil.which("node") is None or shutil.which("npm") is None:
        pytest.skip("no node and npm on this machine")
    PACKAGES.mkdir(parents=True, exist_ok=True)
    for name in ("package.json", "read_log.mjs"):
        shutil.copy(READER / name, PACKAGES)
    if not (PACKAGES / "node_modules" / "@mcap" / "core").exists():
        command = ["npm", "install", "--no-package-lock", "--no-audit", "--no-fund", "--ignore-scripts"]
        done = subprocess.run(command, cwd=PACKAGES, capture_output=True, text=True, timeout=300, check=False)
        if done.returncode:
            pytest.skip(f"npm cannot install the readers: {done.stderr.strip()[-200:]}")
    return PACKAGES / "read_log.mjs"


def read_by_javascript(script: Path, log: Path) -> dict[str, Any]:
    node = shutil.which("node") or "node"
    done = subprocess.run([node, script, log], capture_output=True, text=True, timeout=60, check=True)
    found: dict[str, Any] = json.loads(done.stdout)
    return found


def test_javascript_reads_our_own_messages(javascript: Path, tmp_path: Path) -> None:
    log = small_log(tmp_path / "run.mcap")
    run = RunTables.read(log)

    topics = read_by_javascript(javascript, log)

    state, tick = topics["passafe/robot/plant/state"], topics["passafe/robot/filter/tick"]
    assert (state["count"], tick["count"]) == (4, 3)
    assert state["schema"] == "passafe.v1.PlantState"
    assert state["newest"]["x"] == run.states.matrix("x")[-1].tolist()
    assert state["newest"]["header"]["epoch"] == str(LARGE)
    assert tick["newest"]["status"] == "MODIFIED"
    assert [(one["name"], one["psi"]) for one in tick["newest"]["barriers"]] == [("disk", [2.5, 2.0, 3.0])]


def test_javascript_reads_what_viewers_get(javascript: Path, tmp_path: Path) -> None:
    write_foxglove(LogScan.of(small_log(tmp_path / "run.mcap")), tmp_path / "view.mcap")

    topics = read_by_javascript(javascript, tmp_path / "view.mcap")

    assert topics["/passafe/tick"]["newest"]["barrier_disk_psi_0"] == 2.5
    assert topics["/tf"]["newest"]["transforms"][0]["child_frame_id"] == "robot"
    assert topics["/passafe/log"]["newest"]["level"] == "WARNING"
    assert topics["/passafe/scene/barriers"]["newest"]["entities"][0]["id"] == "disk"


def test_mcaps_own_reader_reads_our_own_messages(tmp_path: Path) -> None:
    log = small_log(tmp_path / "run.mcap")

    with log.open("rb") as stream:
        messages = list(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())

    counts = Counter(message.schema.name for message in messages if message.schema is not None)
    expected = {"PlantState": 4, "FilterTick": 3, "Event": 1, "Health": 2}
    assert counts == {f"passafe.v1.{name}": number for name, number in expected.items()}
    assert [one.decoded_message.x[0] for one in messages if one.channel.topic.endswith("state")] == [0.0, 1.0, 2.0, 3.0]


def test_a_bag_of_ros_2_has_the_standard_messages(tmp_path: Path) -> None:
    [bag] = write_ros2(LogScan.of(small_log(tmp_path / "run.mcap")), tmp_path / "bag")

    with AnyReader([bag]) as reader:
        found = {}
        for connection, time_ns, data in reader.messages():
            found.setdefault(connection.topic, []).append((time_ns, reader.deserialize(data, connection.msgtype)))

    assert sorted(path.name for path in bag.iterdir()) == ["bag.mcap", "metadata.yaml"]
    poses = found["/passafe/pose"]
    assert [pose.pose.position.x for _, pose in poses] == [0.0, 1.0, 2.0, 3.0]
    assert poses[0][0] == WALL_NS == poses[0][1].header.stamp.sec * 10**9 + poses[0][1].header.stamp.nanosec
    assert found["/passafe/twist"][0][1].twist.linear.y == -1.0
    assert found["/tf"][0][1].transforms[0].child_frame_id == "robot"
    assert [one.data for _, one in found["/passafe/barrier/disk"]] == [0.5, 1.5, 2.5]
    assert found["/passafe/status"][0][1].data == "MODIFIED"
    assert found["/passafe/state"][3][1].data.tolist() == [3.0, 2.0, 0.0, -1.0]
    assert (found["/rosout"][0][1].level, found["/rosout"][0][1].name) == (30, "filter")
    [plant, _] = [one.status[0] for _, one in found["/diagnostics"]]
    assert (plant.name, plant.level, plant.message) == ("plant", 1, "messages missing or refused")
    assert {one.key: one.value for one in plant.values}["input_gaps"] == "1"
