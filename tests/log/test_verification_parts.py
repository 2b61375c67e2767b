"""Verified logs that are torn, damaged, rotated, or of before."""

from pathlib import Path

from mcap.writer import Writer
from passafe_protocol.topics import STATE
from passafe_services.keys.authority import Authority, KeyPair
from passafe_services.log.log_files import files_of
from passafe_services.log.log_writer import LogWriter
from passafe_services.log.segmented_log import Rotation
from passafe_services.log.verification import verify
from passafe_services.tools.recover import recover
from signed_logs import NOW_NS, named, record, signer_of, state


def test_a_torn_log_verifies_up_to_its_last_checkpoint(
    tmp_path: Path, pair: KeyPair, authority: Authority, pinned: Path
) -> None:
    path, torn, out = (tmp_path / name for name in ("run.mcap", "torn.mcap", "out.mcap"))
    record(path, signer_of(pair, authority))
    torn.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    found = verify(torn, pinned)
    assert 0 < found.attested < 80
    assert found.found == []
    assert any("the end is missing" in doubt for doubt in found.doubts)
    recover(torn, out)
    again = verify(out, pinned)
    assert (again.attested, again.found) == (found.attested, [])


def test_messages_after_the_last_checkpoint_are_reported(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    writer = LogWriter(path, {})
    for k in range(5):
        writer.write(*state(k)[:2], sequence=k, wall_ns=state(k).wall_ns)
    writer._file.flush()
    found = verify(path)
    writer.close()
    assert (found.unattested, found.unattested_from_ns) == (5, NOW_NS)
    assert "5 messages after the last checkpoint are not attested" in found.doubts


def test_a_chain_goes_over_rotated_files(tmp_path: Path, pair: KeyPair, authority: Authority, pinned: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, signer_of(pair, authority), Rotation(size_bytes=6000))
    files = files_of(path)
    assert len(files) > 2
    assert verify(path, pinned).holds
    files[1].unlink()
    found = verify(path, pinned)
    assert not found.holds
    assert any("are missing" in doubt for doubt in found.doubts)


def test_damage_is_reported_and_its_messages_named(log: Path, pinned: Path, tmp_path: Path) -> None:
    content = bytearray(log.read_bytes())
    chunks = [at for at in range(len(content)) if content.startswith(b"\x28\xb5\x2f\xfd", at)]
    content[chunks[2] + 40] ^= 1
    log.write_bytes(content)
    for path in (log, tmp_path / "out.mcap"):
        if path != log:
            recover(log, path)
        found = verify(path, pinned)
        assert {change for change, *_ in named(found)} == {"left out"}
        assert [sequence for _, key, sequence, _ in named(found) if key == STATE.key("plant")] == list(range(20, 30))


def test_a_log_of_before_has_no_checkpoints(tmp_path: Path) -> None:
    path = tmp_path / "old.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()  # type: ignore[no-untyped-call]  # mcap leaves it unannotated
    assert verify(path).doubts == ["it has no checkpoints: it was written before there were any, or by another program"]
