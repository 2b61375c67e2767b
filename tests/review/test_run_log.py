"""Reading logs: complete, truncated, with gaps and duplicates, foreign and damaged."""

import json
from pathlib import Path

import pytest
from damped_point_run import PERIOD_NS, Run, header, rollout, scenario, state, tick
from mcap.writer import Writer
from passafe_protocol.codec import encode
from passafe_protocol.messages import (
    SCHEMA_VERSION,
    Event,
    FilterTick,
    Health,
    OperatorCommand,
    PlantState,
    ScenarioInfo,
)
from passafe_protocol.topics import STATE
from passafe_services.log.errors import ForeignLogError, LogFileError, LogReadError
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.tools.recover import recover
from passafe_services.tools.review.errors import ScenarioRecordError
from passafe_services.tools.review.run_log import RunLog


def small_run() -> Run:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: (0.0, 0.0), steps=30)
    return run


def test_every_message_comes_back_as_it_was_sent(tmp_path: Path) -> None:
    run = small_run()
    log = RunLog.read(run.write(tmp_path / "run.mcap"))
    assert log.finished
    assert log.tear == ""
    assert log.identity.scenario == scenario()
    assert log.identity.driver == "live"
    assert log.identity.versions == {"passafe": "0.1.0"}
    for body in (OperatorCommand, FilterTick, PlantState):
        sent = [message for message in run.sent if isinstance(message[1], body)]
        assert [tuple(message) for message in log.of(body)] == sent
    assert log.of(Health) == []
    assert log.counts["state"].received == 30
    assert {name: count.gaps for name, count in log.counts.items() if count.gaps} == {}


def test_order_gaps_and_repetitions_are_per_source_and_session(tmp_path: Path) -> None:
    run = Run()
    for source, epoch, sequences in (
        ("plant", 1, (0, 1, 2)),
        ("filter", 7, (5, 3, 8, 3)),
        ("plant", 2, (0, 4)),
    ):
        for sequence in sequences:
            run.add(header(source, sequence, epoch=epoch), Event("info", f"{source} {epoch} {sequence}"))
    log = RunLog.read(run.write(tmp_path / "run.mcap"))
    texts = [message.body.text for message in log.of(Event)]
    assert texts == [
        *("filter 7 3", "filter 7 5", "filter 7 8"),
        *("plant 1 0", "plant 1 1", "plant 1 2", "plant 2 0", "plant 2 4"),
    ]
    count = log.counts["event"]
    assert (count.received, count.duplicates) == (8, 1)
    assert count.gaps == 1 + 2 + 3  # filter: 4, and 6 to 7; plant's second session: 1 to 3
    assert count.missed_at_start == 3
    assert count.sessions == 3
    assert count.first_gap_wall_ns == header("plant", 0).wall_ns


def test_messages_missing_before_a_second_session_are_a_gap(tmp_path: Path) -> None:
    run = Run()
    for epoch, sequences in ((1, (2, 3)), (2, (4, 5))):
        for sequence in sequences:
            run.add(header("plant", sequence, epoch=epoch), Event("info", "x"))
    count = RunLog.read(run.write(tmp_path / "run.mcap")).counts["event"]
    assert (count.missed_at_start, count.gaps, count.sessions) == (2, 4, 2)
    assert count.first_gap_wall_ns == header("plant", 3).wall_ns


def test_messages_that_are_not_valid_are_counted(tmp_path: Path) -> None:
    good = encode(header("plant", 0), state(0, (1, 2, 3, 4), (5, 6)))
    other_version = good.replace(bytes((8, SCHEMA_VERSION)), bytes((8, SCHEMA_VERSION + 1)), 1)
    path = tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario().model_dump_json(), versions={}, driver="live")
    with LogWriter(path, metadata) as log:
        for data in (good, good[:-3], b"garbage", b"", other_version):
            log.write(STATE.key("plant"), data, sequence=0, wall_ns=0)
        log.write("somebody/elses/key", b"whatever", sequence=0, wall_ns=0)
    read = RunLog.read(path)
    assert read.counts["state"].undecodable == 4
    assert len(read.of(PlantState)) == 1
    assert read.foreign_keys == ("somebody/elses/key",)


def test_a_torn_log_is_read_up_to_the_tear(tmp_path: Path) -> None:
    run = small_run()
    path = tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=run.scenario.model_dump_json(), versions={}, driver="lockstep")
    log = LogWriter(path, metadata)
    for head, body in run.sent:
        if isinstance(body, PlantState):
            log.write(STATE.key("plant"), encode(head, body), sequence=head.sequence, wall_ns=head.wall_ns)
            if head.sequence == 19:
                log.flush()
                flushed_bytes = path.stat().st_size
    log.flush()
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(path.read_bytes()[: flushed_bytes + 100])
    read = RunLog.read(torn)
    assert not read.finished
    assert f"of {flushed_bytes + 100} bytes" in read.tear
    assert [message.header.sequence for message in read.of(PlantState)] == list(range(20))
    assert read.identity.driver == "lockstep"
    recovered = tmp_path / "recovered.mcap"
    recover(torn, recovered)
    again = RunLog.read(recovered)
    assert again.of(PlantState) == read.of(PlantState)
    assert not again.finished  # the end is still missing, however whole the file
    assert again.tear == read.tear
    log.close()


def test_published_scenario_replaces_missing_metadata(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    info = ScenarioInfo(scenario(mode="safe").model_dump_json(), "lockstep", json.dumps({"piqp": "0.7"}))
    with LogWriter(path, {}) as log:
        log.write("passafe/robot/filter/scenario", encode(header("filter", 0), info), sequence=0, wall_ns=0)
    read = RunLog.read(path)
    assert read.identity.scenario.filter.mode == "safe"
    assert read.identity.driver == "lockstep"
    assert read.identity.versions == {"piqp": "0.7"}


def unfit(tmp_path: Path) -> dict[str, tuple[Path, type[LogFileError], str]]:
    """Files that cannot be reviewed, what is raised for each and part of the message."""
    files = {name: tmp_path / f"{name}.mcap" for name in ("empty", "text", "foreign", "silent", "newer")}
    files["empty"].touch()
    files["text"].write_text("time,x\n0,1\n" * 100)
    with files["foreign"].open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("/camera/image", "cdr", 0)
        writer.add_message(channel, 0, b"pixels", 0)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    with LogWriter(files["silent"], {}) as log:
        log.write("passafe/robot/filter/tick", encode(header("filter", 0), tick(0, (0, 0))), sequence=0, wall_ns=0)
    newer = scenario().model_dump_json().replace('"schema_version":1', '"schema_version":2')
    with LogWriter(files["newer"], run_metadata(scenario_json=newer, versions={}, driver="live")):
        pass
    return {
        "missing": (tmp_path / "missing.mcap", LogReadError, "no such file"),
        "folder": (tmp_path, LogReadError, "recordings"),
        "empty": (files["empty"], LogReadError, "is empty"),
        "text": (files["text"], LogReadError, "is no MCAP file"),
        "foreign": (files["foreign"], ForeignLogError, "/camera/image"),
        "silent": (files["silent"], ScenarioRecordError, "does not say which scenario"),
        "newer": (files["newer"], ScenarioRecordError, "schema_version"),
    }


@pytest.mark.parametrize("name", ["missing", "folder", "empty", "text", "foreign", "silent", "newer"])
def test_invalid_file_is_reported_in_one_line(tmp_path: Path, name: str) -> None:
    path, kind, part = unfit(tmp_path)[name]
    with pytest.raises(kind) as caught:
        RunLog.read(path)
    assert caught.value.path == path
    assert part in str(caught.value)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_driver_that_does_not_exist_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    metadata = run_metadata(scenario_json=scenario().model_dump_json(), versions={}, driver="live")
    with LogWriter(path, metadata | {"driver": {"kind": "magic"}}):
        pass
    with pytest.raises(ScenarioRecordError, match="driver"):
        RunLog.read(path)


def test_finished_log_without_messages_is_an_empty_run(tmp_path: Path) -> None:
    log = RunLog.read(Run().write(tmp_path / "run.mcap"))
    assert log.of(PlantState) == []
    assert log.counts["state"].received == 0
    assert log.identity.scenario.dt_s * 1e9 == PERIOD_NS
