"""Credentials: keys that cannot be used are refused by name, before a session is opened."""

import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from passafe_protocol.identity import Identity
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.keys.errors import (
    ForeignKeysError,
    KeysExpiredError,
    KeysMismatchError,
    KeysMissingError,
    KeysUnreadableError,
)


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    Deployment.create(tmp_path / "keys").issue(identities_of(["arm"], ["eve"]), days=10)
    return tmp_path / "keys"


def test_folder_of_deployment_or_of_holder_will_do(keys: Path) -> None:
    for folder in (keys, keys / "filter.arm"):
        found = load_credentials(folder, "filter", "arm")
        assert found.identity == Identity(role="filter", robot="arm")
        assert found.days_left() == pytest.approx(10.0, abs=0.01)
    assert load_credentials(keys / "operator.arm.eve", "operator", "arm").identity.name == "eve"


@pytest.mark.parametrize("file", ["ca.pem", "certificate.pem", "key.pem"])
def test_missing_file_is_named(keys: Path, file: str) -> None:
    (keys / "plant.arm" / file).unlink()

    with pytest.raises(KeysMissingError, match=r"plant\.arm"):
        load_credentials(keys, "plant", "arm")


@pytest.mark.parametrize("file", ["ca.pem", "certificate.pem", "key.pem"])
def test_damaged_file_is_named(keys: Path, file: str) -> None:
    path = keys / "plant.arm" / file
    path.write_bytes(path.read_bytes()[:90])

    with pytest.raises(KeysUnreadableError, match=file):
        load_credentials(keys, "plant", "arm")


def test_a_folder_that_is_none_is_missing(keys: Path) -> None:
    for path in (keys / "nowhere", keys / "router" / "key.pem"):
        with pytest.raises(KeysMissingError):
            load_credentials(path, "plant", "arm")


@pytest.mark.parametrize("days", [-1.0, 11.0])
def test_certificate_outside_its_time_is_refused(keys: Path, days: float) -> None:
    at = datetime.now(UTC) + timedelta(days=days)

    with pytest.raises(KeysExpiredError, match=r"renew it with `passafe keys renew`, or set the clock"):
        load_credentials(keys, "plant", "arm", now=at)


def test_certificate_of_another_authority_is_refused(keys: Path, tmp_path: Path) -> None:
    Deployment.create(tmp_path / "other").issue(identities_of(["arm"]))
    shutil.copy(tmp_path / "other" / "plant.arm" / "ca.pem", keys / "plant.arm" / "ca.pem")

    with pytest.raises(ForeignKeysError):
        load_credentials(keys, "plant", "arm")


@pytest.mark.parametrize(("role", "robot"), [("filter", "arm"), ("operator", "leg"), ("router", "")])
def test_certificate_of_another_role_or_robot_is_refused(keys: Path, role: str, robot: str) -> None:
    with pytest.raises(KeysMismatchError, match=rf"certificate: got 'operator\.arm', allowed one for {role}"):
        load_credentials(keys / "operator.arm", role, robot)


def test_key_of_another_certificate_is_refused(keys: Path) -> None:
    shutil.copy(keys / "filter.arm" / "key.pem", keys / "plant.arm" / "key.pem")

    with pytest.raises(KeysUnreadableError, match="the key of another certificate"):
        load_credentials(keys, "plant", "arm")


def test_key_that_everybody_can_read_is_refused(keys: Path) -> None:
    (keys / "plant.arm" / "key.pem").chmod(0o644)

    with pytest.raises(KeysUnreadableError, match=r"got mode 0644, allowed 0600 or 0640"):
        load_credentials(keys, "plant", "arm")


def test_key_of_another_kind_is_refused(keys: Path) -> None:
    pem = rsa.generate_private_key(65537, 2048).private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    (keys / "plant.arm" / "key.pem").write_bytes(pem)

    with pytest.raises(KeysUnreadableError, match="a key of another kind"):
        load_credentials(keys, "plant", "arm")


@pytest.mark.parametrize("names", [[], ["plant.arm", "filter.arm"], ["plant.*"], ["Plant.arm"], ["plant.arm "]])
def test_certificate_must_have_one_common_name_of_ours(keys: Path, names: list[str]) -> None:
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name) for name in names])
    now = datetime.now(UTC)
    builder = x509.CertificateBuilder(subject, subject, key.public_key(), 1, now, now + timedelta(days=1))
    certificate = builder.sign(key, hashes.SHA256())
    (keys / "plant.arm" / "certificate.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))

    with pytest.raises(KeysUnreadableError, match=r"common name"):
        load_credentials(keys, "plant", "arm")
