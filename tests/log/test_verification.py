"""Verified logs: whatever is changed after the recorder wrote it is found and named, checksums recomputed or not."""

from pathlib import Path
from typing import Any

import msgspec
import pytest
from mcap.records import Channel, McapRecord, Message, Metadata, Schema
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import PlantState
from passafe_protocol.topics import STATE
from passafe_services.log.log_reader import LogReader
from passafe_services.log.verification import verify
from passafe_services.tools.recover import recover
from signed_logs import named, record, rewritten, states


def test_a_signed_log_verifies(log: Path, pinned: Path) -> None:
    found = verify(log, pinned)
    assert (found.holds, found.doubts, found.found) == (True, [], [])
    assert (found.messages, found.attested, found.unattested) == (80, 80, 0)
    assert (found.signer, found.is_pinned) == ("recorder.robot", True)
    assert not verify(log).is_pinned


@pytest.mark.parametrize("which", [0, 9, 10, 33, 59])
def test_a_changed_float_is_named(log: Path, pinned: Path, which: int) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        message: Any = records[states(records)[which]]
        header, body = decode(STATE, message.data)
        message.data = encode(header, replace_x(body))
        return records

    rewritten(log, change)
    found = verify(log, pinned)
    assert not found.holds
    assert named(found) == [("changed", STATE.key("plant"), which, which)]
    assert found.attested == 79


def replace_x(body: object) -> PlantState:
    """Return a state with one float changed by the last bit."""
    assert isinstance(body, PlantState)
    return msgspec.structs.replace(body, x=(1.0000000000000002, 2.0))


def test_a_message_left_out_is_named(log: Path, pinned: Path) -> None:
    rewritten(log, lambda records: [each for k, each in enumerate(records) if k != states(records)[17]])
    found = verify(log, pinned)
    assert named(found) == [("left out", STATE.key("plant"), 17, 17)]


def test_swapped_messages_are_named(log: Path, pinned: Path) -> None:
    def swap(records: list[McapRecord]) -> list[McapRecord]:
        one, other = states(records)[21], states(records)[22]
        records[one], records[other] = records[other], records[one]
        return records

    rewritten(log, swap)
    assert named(verify(log, pinned)) == [("moved", STATE.key("plant"), k, k) for k in (21, 22)]


def test_a_swap_over_a_checkpoint_is_named(log: Path, pinned: Path) -> None:
    def swap(records: list[McapRecord]) -> list[McapRecord]:
        one, other = states(records)[19], states(records)[20]
        records[one], records[other] = records[other], records[one]
        return records

    rewritten(log, swap)
    assert {(change, sequence) for change, _, sequence, _ in named(verify(log, pinned))} == {
        ("left out", 19),
        ("left out", 20),
        ("added", 19),
        ("added", 20),
    }


def test_an_added_message_is_named(log: Path, pinned: Path) -> None:
    rewritten(log, lambda records: [*records[: states(records)[5]], *records[states(records)[4] :]])
    assert named(verify(log, pinned)) == [("added", STATE.key("plant"), 4, 4)]


def test_moved_messages_are_as_few_as_can_be(log: Path, pinned: Path) -> None:
    def move(records: list[McapRecord]) -> list[McapRecord]:
        places = states(records)
        records.insert(places[38], records.pop(places[31]))
        return records

    rewritten(log, move)
    assert named(verify(log, pinned)) == [("moved", STATE.key("plant"), 31, 31)]


@pytest.mark.parametrize("first", [Metadata, Message])
def test_a_log_that_a_tool_wrote_anew_is_compared_by_message(log: Path, pinned: Path, first: type) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        del records[states(records)[44]]
        message: Any = records[states(records)[33]]
        header, body = decode(STATE, message.data)
        message.data = encode(header, replace_x(body))
        messages = [each for each in records if isinstance(each, Message)]
        messages.sort(key=lambda each: (each.log_time, -each.channel_id))
        metadata = [each for each in records if isinstance(each, Metadata)]
        others = [each for each in records if isinstance(each, Schema | Channel)]
        return [*others, *metadata, *messages] if first is Metadata else [*others, *messages, *metadata]

    rewritten(log, change)
    found = verify(log, pinned)
    assert named(found) == [("changed", STATE.key("plant"), 33, 33), ("left out", STATE.key("plant"), 44, 44)]
    assert found.attested == 78
    assert any("it was written anew" in doubt for doubt in found.doubts)


def test_changed_metadata_is_named(log: Path, pinned: Path) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        for each in records:
            if isinstance(each, Metadata) and each.name == "driver":
                each.metadata = {"kind": "lockstep"}
        return records

    rewritten(log, change)
    assert verify(log, pinned).doubts == ["metadata record driver is not as it was written"]
    assert recover(log, log.with_name("out.mcap")).altered == ("driver",)


def is_checkpoint(record: McapRecord) -> bool:
    return isinstance(record, Metadata) and record.name == "checkpoint"


def test_a_checkpoint_left_out_is_named(log: Path, pinned: Path) -> None:
    def change(records: list[McapRecord]) -> list[McapRecord]:
        del records[[k for k, each in enumerate(records) if is_checkpoint(each)][3]]
        return records

    rewritten(log, change)
    found = verify(log, pinned)
    assert not found.holds
    assert "checkpoints 3 to 3 are missing" in found.doubts
    assert {change for change, *_ in named(found)} == {"added"}


def test_checkpoints_computed_anew_are_not_signed(log: Path, pinned: Path, tmp_path: Path) -> None:
    forged = tmp_path / "forged.mcap"
    record(forged, None)

    def with_signer(records: list[McapRecord]) -> list[McapRecord]:
        [of_signer] = [
            each for each in LogReader(log).records() if isinstance(each, Metadata) and each.name == "signer"
        ]
        return [records[0], of_signer, *records[1:]]

    rewritten(forged, with_signer)
    found = verify(forged, pinned)
    assert not found.holds
    assert found.attested == 0
    assert "checkpoints without a valid signature: 8, the first 0" in found.doubts
