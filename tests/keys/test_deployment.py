"""Deployments: who gets which certificate, in which files, for how long."""

import stat
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.x509.oid import ExtendedKeyUsageOID
from passafe_protocol.identity import ROLES, Identity
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.keys.errors import KeysExistError, KeysMissingError
from passafe_services.keys.key_files import KeyFolder, is_issued_by, read_certificate

ALICE = Identity(role="operator", robot="left", name="alice")


@pytest.fixture
def deployment(tmp_path: Path) -> Deployment:
    made = Deployment.create(tmp_path / "keys")
    made.issue(identities_of(["left", "right"], ["alice"]), hosts=["router.example", "192.0.2.7"], days=30)
    return made


def folder(deployment: Deployment, common_name: str) -> KeyFolder:
    return KeyFolder(path=deployment.path / common_name)


def extension(deployment: Deployment, common_name: str, kind: type) -> object:
    return read_certificate(folder(deployment, common_name).certificate).extensions.get_extension_for_class(kind).value


def test_every_role_of_every_robot_has_a_certificate(deployment: Deployment) -> None:
    names = {holder.identity.common_name for holder in deployment.holders()}

    assert names == {
        "router",
        *(f"{role}.{robot}" for role in ROLES for robot in ("left", "right")),
        "operator.left.alice",
        "operator.right.alice",
    }


def test_private_keys_are_for_their_owner_alone(deployment: Deployment) -> None:
    keys = sorted(deployment.path.glob("*/*key.pem"))

    assert len(keys) == len(deployment.holders()) + 1  # and that of the authority
    assert {stat.S_IMODE(key.stat().st_mode) for key in keys} == {0o600}
    assert {stat.S_IMODE(key.parent.stat().st_mode) for key in keys} == {0o700}


def test_only_the_router_may_listen(deployment: Deployment) -> None:
    listens = ExtendedKeyUsageOID.SERVER_AUTH

    assert listens in extension(deployment, "router", x509.ExtendedKeyUsage)
    assert listens not in extension(deployment, "operator.left", x509.ExtendedKeyUsage)
    names = extension(deployment, "router", x509.SubjectAlternativeName)
    assert {"router.example", "localhost"} <= {*names.get_values_for_type(x509.DNSName)}
    assert {"192.0.2.7", "127.0.0.1", "::1"} == {str(one) for one in names.get_values_for_type(x509.IPAddress)}


def test_no_certificate_outlasts_its_authority(tmp_path: Path) -> None:
    short = Deployment.create(tmp_path / "short", authority_days=2.0)
    short.issue([ALICE], days=500)

    [holder] = short.holders()
    assert abs(holder.ends - datetime.now(UTC) - timedelta(days=2)) < timedelta(minutes=5)


def test_an_added_person_is_admitted_and_a_removed_one_is_not(deployment: Deployment) -> None:
    bob = Identity(role="operator", robot="right", name="bob")
    Deployment.open(deployment.path).issue([bob])
    assert bob in folder(deployment, "router").read_admitted()

    deployment.remove(bob)
    assert bob not in folder(deployment, "router").read_admitted()
    assert not folder(deployment, "operator.right.bob").path.exists()
    with pytest.raises(KeysMissingError, match=r"there is no operator\.right\.bob"):
        deployment.remove(bob)


def test_renewal_keeps_the_authority_and_changes_the_key(deployment: Deployment) -> None:
    old = read_certificate(folder(deployment, "plant.left").certificate)
    deployment.issue([Identity(role="plant", robot="left")], days=90)

    new = read_certificate(folder(deployment, "plant.left").certificate)
    assert new.public_key() != old.public_key()
    assert new.not_valid_after_utc - old.not_valid_after_utc > timedelta(days=59)
    authority = read_certificate(folder(deployment, "plant.left").authority)
    assert is_issued_by(new, authority)
    assert is_issued_by(old, authority)


def test_an_existing_deployment_is_not_overwritten(deployment: Deployment, tmp_path: Path) -> None:
    with pytest.raises(KeysExistError):
        Deployment.create(deployment.path)
    with pytest.raises(KeysMissingError):
        Deployment.open(tmp_path)
