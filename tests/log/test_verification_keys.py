"""Verified logs: whose signature proves what."""

import time
from pathlib import Path

import pytest
from passafe_protocol.identity import Identity
from passafe_services.keys.authority import Authority, KeyPair
from passafe_services.keys.errors import KeysMissingError, KeysUnreadableError
from passafe_services.log.verification import verify
from signed_logs import NOW_NS, S, record, signer_of


def test_a_log_without_keys_is_not_verified(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, None)
    found = verify(path)
    assert (found.holds, found.found) == (False, [])
    assert found.doubts == ["it is not signed: whoever can write the file can compute its checkpoints anew"]


def test_a_pinned_file_must_be_a_certificate(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, None)
    with pytest.raises(KeysMissingError):
        verify(path, tmp_path / "none.pem")
    with pytest.raises(KeysUnreadableError):
        verify(path, path)
    with pytest.raises(KeysUnreadableError, match="device"):
        verify(path, Path("/dev/zero"))


def test_a_signature_of_another_authority_is_no_proof(log: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.pem"
    other.write_bytes(Authority.create(days=1).pair.certificate)
    found = verify(log, other)
    assert not found.holds
    assert "is not of the authority" in found.doubts[0]


def test_the_recorders_certificate_may_be_pinned(log: Path, tmp_path: Path, pair: KeyPair) -> None:
    path = tmp_path / "recorder.pem"
    path.write_bytes(pair.certificate)
    assert verify(log, path).holds


def test_another_roles_signature_is_no_proof(tmp_path: Path, authority: Authority, pinned: Path) -> None:
    path = tmp_path / "run.mcap"
    record(path, signer_of(authority.issue(Identity(role="plant", robot="robot"), days=3650), authority))
    assert verify(path, pinned).doubts == ["it is signed by plant.robot, which is no recorder"]


def test_a_certificate_that_had_expired_is_no_proof(tmp_path: Path, authority: Authority, pinned: Path) -> None:
    path = tmp_path / "run.mcap"
    days = (NOW_NS / S + 25 - time.time()) / 86_400
    record(path, signer_of(authority.issue(Identity(role="recorder", robot="robot"), days=days), authority))
    found = verify(path, pinned)
    assert 10 <= found.attested <= 40
    assert any("checkpoints without a valid signature" in doubt for doubt in found.doubts)
