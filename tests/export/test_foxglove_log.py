import json
import re
from collections import Counter
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from passafe_services.tables.scan import LogScan
from passafe_services.tools.export.foxglove_log import write_foxglove
from passafe_services.tools.review.run_log import RunLog
from small_log import small_log, tick, write_log


@pytest.fixture
def exported(tmp_path: Path) -> Path:
    write_foxglove(LogScan.of(small_log(tmp_path / "run.mcap")), tmp_path / "view.mcap")
    return tmp_path / "view.mcap"


def test_mcaps_own_reader_decodes_every_message(exported: Path) -> None:
    with exported.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        counts = Counter(message.channel.topic for message in reader.iter_decoded_messages())

    assert counts["passafe/robot/plant/state"] == counts["/passafe/state"] == 4
    assert counts["/passafe/tick"] == 3
    assert {"/tf", "/passafe/poses", "/passafe/scene/robot", "/passafe/scene/barriers", "/passafe/log"} <= set(counts)


def test_schemas_are_those_that_viewers_know(exported: Path) -> None:
    with exported.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    names = {
        summary.channels[one].topic: summary.schemas[summary.channels[one].schema_id].name for one in summary.channels
    }

    assert names["/tf"] == "foxglove.FrameTransforms"
    assert names["/passafe/poses"] == "foxglove.PosesInFrame"
    assert names["/passafe/scene/barriers"] == "foxglove.SceneUpdate"
    assert names["/passafe/log"] == "foxglove.Log"
    assert names["passafe/robot/filter/tick"] == "passafe.v1.FilterTick"


def test_own_messages_stay_as_they_were(exported: Path, tmp_path: Path) -> None:
    before, after = RunLog.read(tmp_path / "run.mcap"), exported

    kept = LogScan.of(after)

    assert {name: number for name, number in kept.counts.items() if number} == {
        name: len(messages) for name, messages in before.messages.items()
    }


def test_every_path_of_the_layout_is_a_number_of_the_log(exported: Path) -> None:
    layout = json.loads(exported.with_suffix(".layout.json").read_text())
    paths = [path["value"] for panel in layout["configById"].values() for path in panel.get("paths", ())]
    with exported.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        fields = {
            f"{message.channel.topic}.{field.name}"
            for message in reader.iter_decoded_messages(topics=["/passafe/tick", "/passafe/state"])
            for field in message.decoded_message.DESCRIPTOR.fields
        }

    assert len(paths) > 10
    assert set(paths) <= fields


def test_every_panel_has_its_place(exported: Path) -> None:
    text = exported.with_suffix(".layout.json").read_text()
    layout = json.loads(text)

    placed = re.findall(r'"(?:first|second)": "([^"]+)"', text)

    assert sorted(placed) == sorted(layout["configById"])


def test_names_that_differ_in_an_underscore_stay_apart(tmp_path: Path) -> None:
    log = write_log(tmp_path / "run.mcap", [("filter", 0, tick(0, barriers=("disk1", "disk_1")))])

    write_foxglove(LogScan.of(log), tmp_path / "view.mcap")

    with (tmp_path / "view.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        [numbers] = [one.decoded_message for one in reader.iter_decoded_messages(topics=["/passafe/tick"])]
    assert numbers.barrier_disk1_psi_0 == numbers.barrier_disk_1_psi_0 == 0.5
