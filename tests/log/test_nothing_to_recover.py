"""Logs of which little or nothing is left: a recovery that keeps nothing is refused, and leaves no file."""

import subprocess
import sys
from pathlib import Path

import pytest
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC, Writer
from passafe_services.log.errors import LogReadError
from passafe_services.tools.recover import recover
from torn_logs import contents, end_of_first, metadata, write_log


def header_alone(path: Path) -> bytes:
    """Return the bytes of a log up to the end of its header."""
    write_log(path)
    return path.read_bytes()[: end_of_first(Opcode.HEADER, path)]


@pytest.mark.parametrize("more", [b"", b"\x05\x00", b"\x00" * 5000, b"no record at all, " * 300])
@pytest.mark.parametrize("header", [True, False])
def test_log_of_which_nothing_is_intact_is_refused(tmp_path: Path, more: bytes, *, header: bool) -> None:
    whole, torn, out = (tmp_path / name for name in ("whole.mcap", "torn.mcap", "out.mcap"))
    content = header_alone(whole) if header else MCAP0_MAGIC
    torn.write_bytes(content + more)
    with pytest.raises(LogReadError, match=r"nothing to recover: of \d+ bytes not all are intact"):
        recover(torn, out)
    assert set(tmp_path.iterdir()) == {whole, torn} if header else {torn}


def test_command_refuses_a_log_without_anything_intact(tmp_path: Path) -> None:
    torn, out = tmp_path / "torn.mcap", tmp_path / "out.mcap"
    torn.write_bytes(MCAP0_MAGIC)
    command = [sys.executable, "-m", "passafe_services.cli", "recover", str(torn), "--out", str(out)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr.startswith(f"passafe: {torn}: nothing to recover: of 8 bytes not all are intact")
    assert list(tmp_path.iterdir()) == [torn]


def test_messages_of_unknown_channels_alone_are_refused(tmp_path: Path) -> None:
    torn, out = tmp_path / "torn.mcap", tmp_path / "out.mcap"
    message = b"\x05" + (24).to_bytes(8, "little") + bytes(22) + b"{}"
    torn.write_bytes(header_alone(tmp_path / "whole.mcap") + message)
    with pytest.raises(LogReadError, match="and 1 messages of which no intact record says what they are"):
        recover(torn, out)
    assert not out.exists()


def test_metadata_alone_is_kept(tmp_path: Path) -> None:
    whole, torn, out = (tmp_path / name for name in ("whole.mcap", "torn.mcap", "out.mcap"))
    write_log(whole)
    torn.write_bytes(whole.read_bytes()[: end_of_first(Opcode.METADATA, whole) + 1])
    recovery = recover(torn, out)
    assert (recovery.messages, recovery.was_finished) == (0, False)
    assert (contents(out), metadata(out)["driver"]) == ([], {"kind": "live"})


def test_whole_log_without_a_message_is_copied(tmp_path: Path) -> None:
    whole, out = tmp_path / "whole.mcap", tmp_path / "out.mcap"
    with whole.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    recovery = recover(whole, out)
    assert (recovery.messages, recovery.was_finished) == (0, True)
    assert contents(out) == []
