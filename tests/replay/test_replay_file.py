"""Replay of a file: in one pass, from the log alone, whatever the order of its messages."""

import random
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.records import Channel, Metadata
from mcap.records import Message as Logged
from msgspec.structs import replace
from passafe_protocol.codec import decode, encode
from passafe_protocol.messages import FilterTick
from passafe_protocol.topics import TICK
from passafe_services.cli.app import app
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import LogWriter, topic_of_key
from passafe_services.scenarios.info import versions
from passafe_services.tools.replay import filter_replay
from passafe_services.tools.replay.replay_log import replay_file
from typer.testing import CliRunner

GOLDEN = Path(__file__).parents[1] / "golden" / "bad-links.mcap"

Messages = list[tuple[str, Logged]]


def rewritten(
    target: Path,
    change: Callable[[Messages], Messages] = lambda messages: messages,
    metadata: Callable[[dict[str, dict[str, str]]], object] = lambda records: records,
) -> Path:
    """Return a copy of the golden log with other messages or metadata."""
    records = list(LogReader(GOLDEN).records())
    keys = {record.id: record.topic for record in records if isinstance(record, Channel)}
    shown = {record.name: record.metadata for record in records if isinstance(record, Metadata)}
    metadata(shown)
    with LogWriter(target, shown) as writer:
        for key, each in change([(keys[r.channel_id], r) for r in records if isinstance(r, Logged)]):
            writer.write(key, each.data, sequence=each.sequence, wall_ns=each.log_time)
    return target


def with_tick(number: int, **fields: object) -> Callable[[Messages], Messages]:
    def change(messages: Messages) -> Messages:
        changed = []
        for key, each in messages:
            if topic_of_key(key) is TICK:
                header, body = decode(TICK, each.data)
                assert isinstance(body, FilterTick)
                if body.tick == number:
                    each.data = encode(header, replace(body, **fields))
            changed.append((key, each))
        return changed

    return change


def test_first_differing_field_is_named_with_both_values(tmp_path: Path) -> None:
    path = rewritten(tmp_path / "run.mcap", with_tick(30, slack=0.25))
    result = replay_file(path)
    assert not result.exact
    assert result.first_difference == "tick 30: slack 0.25 -> 0.0"
    assert result.identical == result.ticks - 1


def test_order_of_publishers_in_the_log_does_not_matter(tmp_path: Path) -> None:
    def shuffled(messages: Messages) -> Messages:
        random.Random(7).shuffle(messages)
        return messages

    assert replay_file(rewritten(tmp_path / "run.mcap", shuffled)).exact


def test_ticks_before_all_that_they_consumed(tmp_path: Path) -> None:
    path = rewritten(tmp_path / "run.mcap", lambda all_: sorted(all_, key=lambda each: "tick" not in each[0]))
    assert replay_file(path).exact


def test_gap_ends_the_replay_where_patience_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filter_replay, "PATIENCE", 50)

    def without_a_tick(messages: Messages) -> Messages:
        return [(key, each) for key, each in messages if topic_of_key(key) is not TICK or each.sequence != 20]

    result = replay_file(rewritten(tmp_path / "run.mcap", without_a_tick))
    assert (result.missing, result.ticks, result.identical) == (1, 20, 20)


def test_memory_is_bounded_by_what_a_tick_may_consume(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(filter_replay, "KEPT", 64)  # more than the delays of this log
    assert replay_file(rewritten(tmp_path / "run.mcap")).exact


def test_scenario_comes_from_the_messages_without_metadata(tmp_path: Path) -> None:
    assert replay_file(rewritten(tmp_path / "run.mcap", metadata=dict.clear)).exact


def test_other_versions_are_reported(tmp_path: Path) -> None:
    path = rewritten(tmp_path / "run.mcap", metadata=lambda shown: shown["versions"].update(piqp="0.0.1"))
    own = versions()["piqp"]
    result = CliRunner().invoke(app, ["replay", str(path)])
    assert result.exit_code == 0
    assert f"versions differ, of the log -> here: piqp 0.0.1 -> {own}" in result.output


def test_terminal_names_the_sign_of_a_zero(tmp_path: Path) -> None:
    path = rewritten(tmp_path / "run.mcap", with_tick(30, slack=-0.0))
    result = CliRunner().invoke(app, ["replay", str(path)])
    assert result.exit_code == 1
    assert "first difference, logged -> replayed: tick 30: slack -0.0 -> 0.0" in result.output
