from itertools import count
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from passafe_protocol.codec import encode
from passafe_protocol.topics import STATE, TOPIC_OF_NAME
from passafe_services.log.chain import Chain, RecorderCounts
from passafe_services.log.errors import LogReadError
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.segmented_log import RawMessage, Rotation, SegmentedLog
from passafe_services.tables import scan
from passafe_services.tables.run_tables import RunTables, TopicNameError
from passafe_services.tables.table import ColumnNameError
from small_log import LARGE, WALL_NS, header, small_log, state, tick, write_log


def test_tables_hold_what_was_logged(tmp_path: Path) -> None:
    run = RunTables.read(small_log(tmp_path / "run.mcap"))

    assert run.states["x_1"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert run.states["header_epoch"].tolist() == [LARGE] * 4
    assert run.states["input_lead_ns"].tolist() == [0, -1, -2, -3]
    assert run.ticks["barrier_disk_psi_0"].tolist() == [0.5, 1.5, 2.5]
    assert np.isnan(run.ticks["row_disk_margin"]).tolist() == [True, False, False]
    assert run.events["text"].tolist() == ['the disk, "near"']
    assert run.health["header_source"].tolist() == ["plant", "filter"]
    assert (run.start_ns, run.tear, run.refused) == (WALL_NS, "", {})
    assert run.scenario is not None
    assert run.scenario.name == "notomista-cai-2020"


def test_topics_without_messages_have_empty_tables(tmp_path: Path) -> None:
    run = RunTables.read(small_log(tmp_path / "run.mcap"))

    assert set(run.tables) == set(TOPIC_OF_NAME)
    for table in (run.commands, run.inputs, run.link_events, run.link_states):
        assert len(table) == 0
        assert table["time_s"].size == 0


def test_a_vector_is_a_matrix_and_a_table_a_data_frame(tmp_path: Path) -> None:
    run = RunTables.read(small_log(tmp_path / "run.mcap"))
    frame = run.states.pandas()

    assert run.states.matrix("x").shape == (4, 4)
    assert run.states.matrix("x")[2].tolist() == [2.0, 2.0, 0.0, -1.0]
    assert frame["x_1"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert frame.attrs["units"]["x_1"] == "m"


def test_only_the_topics_asked_for_are_read(tmp_path: Path) -> None:
    run = RunTables.read(small_log(tmp_path / "run.mcap"), topics=["event"])

    assert (len(run.events), len(run.states)) == (1, 0)
    assert run.events["time_s"].tolist() == pytest.approx([0.003])  # from the log's begin, not the topic's


def test_rows_are_in_order_of_log_time(tmp_path: Path) -> None:
    path = write_log(tmp_path / "run.mcap", [("plant", k, state(k)) for k in (0, 3, 1, 2)])

    assert RunTables.read(path).states["x_1"].tolist() == [0.0, 1.0, 2.0, 3.0]


def test_blocks_join_without_a_seam(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scan, "BLOCK_ROWS", 3)
    path = write_log(tmp_path / "run.mcap", [("plant", k, state(k)) for k in range(10)])

    assert RunTables.read(path).states["applied_tick"].tolist() == list(range(10))


def test_unknown_names_are_answered_with_the_nearest(tmp_path: Path) -> None:
    path = small_log(tmp_path / "run.mcap")
    run = RunTables.read(path)

    with pytest.raises(ColumnNameError, match="tank_j"):
        run.ticks["tank"]
    with pytest.raises(ColumnNameError, match="x_1"):
        run.states.matrix("xs")
    with pytest.raises(TopicNameError, match="tick"):
        RunTables.read(path, topics=["ticks"])
    with pytest.raises(TopicNameError, match=r"topics: got 'tick', allowed names in a tuple, such as \('tick',\)"):
        RunTables.read(path, topics="tick")


def test_a_torn_log_is_read_up_to_the_tear(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    whole = write_log(tmp_path / "whole.mcap", [("plant", k, state(k)) for k in range(4)])
    path.write_bytes(whole.read_bytes()[:-40])

    run = RunTables.read(path)

    assert run.states["x_1"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert run.tear


def test_messages_that_do_not_decode_are_counted(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with LogWriter(path, {}) as log:
        log.write("passafe/robot/plant/state", b"nonsense", sequence=0, wall_ns=WALL_NS)

    run = RunTables.read(path)

    assert run.refused == {"state": 1}
    assert run.scenario is None


def test_other_logs_are_refused(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.mcap"
    with foreign.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()
    two = tmp_path / "two.mcap"
    with LogWriter(two, {}) as log:
        for robot in ("left", "right"):
            log.write(f"passafe/{robot}/plant/state", b"", sequence=0, wall_ns=WALL_NS)

    with pytest.raises(LogReadError, match="no log of passafe"):
        RunTables.read(foreign)
    with pytest.raises(LogReadError, match="left, right"):
        RunTables.read(two)
    with pytest.raises(LogReadError, match="no such file"):
        RunTables.read(tmp_path / "none.mcap")


def test_files_of_a_rotated_log_are_one_run(tmp_path: Path) -> None:
    path, ticks = tmp_path / "run.mcap", count()
    log = SegmentedLog(path, {}, Chain("run"), rotation=Rotation(after_ns=1), monotonic_ns=lambda: next(ticks))
    for k in range(6):
        head = header("plant", k)
        log.write(RawMessage(STATE.key("plant"), encode(head, state(k)), k, head.wall_ns))
        log.flush(RecorderCounts())
    log.close(RecorderCounts())

    assert len(list(tmp_path.glob("*.mcap"))) > 1
    assert RunTables.read(path).states["x_1"].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]


def test_a_log_that_grows_meanwhile_is_read_as_it_was(tmp_path: Path) -> None:
    path = write_log(tmp_path / "run.mcap", [("filter", 0, tick(0, rows=()))])
    first = scan.LogScan.of(path)
    write_log(path, [("filter", 0, tick(0, rows=())), ("filter", 1, tick(1))])

    assert [len(block.rows) for block in first.blocks()] == [1]
