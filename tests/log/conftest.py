"""Makes the protocol's strategies importable; a signed log, and the keys that belong to it."""

import sys
from pathlib import Path

import pytest
from passafe_protocol.identity import Identity
from passafe_services.keys.authority import Authority, KeyPair
from signed_logs import record, signer_of

sys.path.append(str(Path(__file__).parents[1] / "protocol"))


@pytest.fixture(scope="module")
def authority() -> Authority:
    """Return an authority of certificates."""
    return Authority.create(days=3650)


@pytest.fixture(scope="module")
def pair(authority: Authority) -> KeyPair:
    """Return the recorder's keys."""
    return authority.issue(Identity(role="recorder", robot="robot"), days=3650)


@pytest.fixture
def log(tmp_path: Path, pair: KeyPair, authority: Authority) -> Path:
    """Return a log that a recorder signed."""
    path = tmp_path / "run.mcap"
    record(path, signer_of(pair, authority))
    return path


@pytest.fixture
def pinned(tmp_path: Path, authority: Authority) -> Path:
    """Return the certificate that a reader trusts."""
    path = tmp_path / "ca.pem"
    path.write_bytes(authority.pair.certificate)
    return path
