"""Sessions with wrong keys fail by a typed error, and known traps of Zenoh's access control stay shut."""

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import zenoh
from attackers import Arena, arena, own_key
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from passafe_protocol.identity import ROUTER, Identity
from passafe_protocol.topics import COMMAND, INPUT
from passafe_services.keys.credentials import Credentials, load_credentials
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.keys.errors import KeysMismatchError, NotAdmittedError
from passafe_services.keys.key_files import KeyFolder, read_certificate, read_key
from passafe_services.loop import routing
from passafe_services.loop.access import access_control
from passafe_services.loop.bus import open_bus
from passafe_services.loop.errors import BusError, OpenRouterError, RoleError
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.routing import listening_router
from passafe_services.loop.session import client_settings, open_session
from running_demo import free_port

pytestmark = pytest.mark.live

PATIENCE_S = 10.0
ROBOT = "left"


@pytest.fixture(scope="module")
def field(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Arena]:
    with arena(tmp_path_factory.mktemp("field") / "keys") as made:
        yield made


def refusal(endpoint: RouterEndpoint) -> str:
    with pytest.raises(BusError) as caught, open_bus(endpoint, robot=ROBOT, timeout_s=0.2):
        pass
    return caught.value.reason


def until(condition: Callable[[], object]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < end_s
        time.sleep(0.01)


def test_a_session_without_keys_is_asked_for_them(field: Arena) -> None:
    assert refusal(field.endpoint) == "the router speaks TLS only: give --keys"


def test_a_session_with_keys_learns_that_the_router_has_none(field: Arena) -> None:
    plain = RouterEndpoint(port=free_port())
    keyed = RouterEndpoint(port=plain.port, credentials=field.with_keys("plant", ROBOT).credentials)
    with listening_router(plain):
        assert "was the router started with --insecure?" in refusal(keyed)
    assert "no router answered" in refusal(keyed)


def test_keys_of_another_deployment_are_refused(field: Arena, tmp_path: Path) -> None:
    Deployment.create(tmp_path / "other").issue(identities_of([ROBOT]))
    stranger = load_credentials(tmp_path / "other", "plant", ROBOT)
    assert "the router's certificate is refused" in refusal(
        RouterEndpoint(port=field.endpoint.port, credentials=stranger)
    )
    shutil.copy(
        field.keys / "router" / "ca.pem", stranger.folder.authority
    )  # it trusts the router, but not so the router
    assert "are these keys of its deployment?" in refusal(
        RouterEndpoint(port=field.endpoint.port, credentials=stranger)
    )


def test_a_process_cannot_pose_as_the_router(field: Arena) -> None:
    posing = RouterEndpoint(port=free_port(), credentials=field.with_keys("operator", ROBOT).credentials)
    shutil.copy(field.keys / "router" / "admitted.txt", posing.credentials.folder.admitted)
    with listening_router(posing):
        victim = RouterEndpoint(port=posing.port, credentials=field.with_keys("plant", ROBOT).credentials)
        assert "the router's certificate is refused" in refusal(victim)


def test_keys_bind_robot_and_role(field: Arena) -> None:
    endpoint = field.with_keys("operator", ROBOT, "operator.left.alice")
    with pytest.raises(KeysMismatchError, match=r"got 'operator\.left\.alice', allowed one for robot right"):
        open_bus(endpoint, robot="right").__enter__()
    with open_bus(endpoint, robot=ROBOT) as bus:
        bus.publisher(COMMAND, "operator")(b"may")
        with pytest.raises(RoleError, match=r"keys to publish input as filter: got 'operator\.left\.alice'"):
            bus.publisher(INPUT, "filter")


def test_a_certificate_that_the_router_does_not_list_is_reported(field: Arena) -> None:
    Deployment.open(field.keys).issue([Identity(role="operator", robot=ROBOT, name="mallory")])
    endpoint = field.with_keys("operator", ROBOT, "operator.left.mallory")
    with (
        pytest.raises(NotAdmittedError, match=r"does not admit 'operator\.left\.mallory': its admitted.txt"),
        open_bus(endpoint, robot=ROBOT, timeout_s=0.3),
    ):
        pass


def test_a_restarted_router_that_admits_less_is_reported(tmp_path: Path) -> None:
    deployment = Deployment.create(tmp_path / "keys")
    deployment.issue(identities_of([ROBOT]))
    router = RouterEndpoint(port=free_port(), credentials=load_credentials(deployment.path, ROUTER))
    plant = RouterEndpoint(port=router.port, credentials=load_credentials(deployment.path, "plant", ROBOT))
    with ExitStack() as stack:
        with listening_router(router):
            bus = stack.enter_context(open_bus(plant, robot=ROBOT))
            assert bus.connected
            assert not bus.refusal
        router.credentials.folder.write_admitted([Identity(role="filter", robot=ROBOT)])
        with listening_router(router):
            until(lambda: "does not admit 'plant.left'" in bus.refusal)
            assert bus.router
            assert not bus.connected  # so no health report says "ok"
        deployment.issue([])
        with listening_router(router):
            until(lambda: bus.connected)


def test_a_certificate_that_expires_ends_its_session(field: Arena) -> None:
    dying = Identity(role="plant", robot=ROBOT)
    folder = field.keys.parent / "dying"
    deployment = Deployment.open(field.keys)
    pair = deployment._authority.issue(dying, days=2.0 / 86_400)
    KeyFolder(path=folder).write(pair, deployment._authority.pair.certificate)
    with open_bus(
        RouterEndpoint(port=field.endpoint.port, credentials=load_credentials(folder, "plant", ROBOT)), robot=ROBOT
    ) as bus:
        assert bus.connected
        until(lambda: not bus.router)


@pytest.mark.parametrize("names", [[], ["operator.left.*"], ["*"], ["Operator.left"], ["operator.left", "filter.left"]])
def test_common_names_are_taken_literally(field: Arena, tmp_path: Path, names: list[str]) -> None:
    folder = signed_for(field.keys, tmp_path / "keys", names)
    holder = Identity(role="operator", robot=ROBOT)
    credentials = Credentials(identity=holder, folder=folder, ends=datetime.now(UTC) + timedelta(days=1))
    filter_key, watch, plant = own_key("filter", ROBOT), field.watch(ROBOT), field.session("plant", ROBOT)
    watch.ready(lambda data: plant.put(own_key("plant", ROBOT), data))
    settings = client_settings(
        RouterEndpoint(port=field.endpoint.port, credentials=credentials).locator, credentials, 0.5
    )
    try:
        session = open_session(settings)
    except zenoh.ZError:
        pass  # refused at once
    else:
        for key in (filter_key, "passafe/left/plant/state", "passafe/**"):
            session.put(key, b"of nobody")
        session.close()
    try:
        assert watch.until(b"the router lives", lambda data: plant.put(own_key("plant", ROBOT), data)) == []
    finally:
        watch.close()


@pytest.mark.parametrize(
    ("trap", "error"),
    [
        (lambda control: control | {"enabled": False}, OpenRouterError),
        (lambda control: control | {"default_permission": "allow"}, OpenRouterError),
        (lambda control: without(control, "enabled"), OpenRouterError),
        (
            lambda control: control | {"subjects": [one | {"interfaces": []} for one in control["subjects"]]},
            BusError,
        ),
        (
            lambda control: control | {"subjects": [one | {"interfaces": ["eth9"]} for one in control["subjects"]]},
            NotAdmittedError,
        ),
    ],
    ids=["not enabled", "allowed by default", "enabled left out", "no interfaces", "another interface"],
)
def test_a_router_with_wrong_rules_is_noticed(
    field: Arena, monkeypatch: pytest.MonkeyPatch, trap: Callable[[dict[str, Any]], dict[str, Any]], error: type
) -> None:
    monkeypatch.setattr(routing, "access_control", lambda admitted: trap(access_control(admitted)))
    port = free_port()
    router = RouterEndpoint(port=port, credentials=field.with_keys(ROUTER).credentials)
    plant = RouterEndpoint(port=port, credentials=field.with_keys("plant", ROBOT).credentials)
    with pytest.raises(error), listening_router(router), open_bus(plant, robot=ROBOT, timeout_s=0.3):
        pass


def without(control: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in control.items() if name != key}


def signed_for(deployment: Path, folder: Path, names: list[str]) -> KeyFolder:
    """Return keys that the deployment's authority has signed for any common names."""
    authority, key = deployment / "authority", ec.generate_private_key(ec.SECP256R1())
    now, issuer = datetime.now(UTC), read_certificate(authority / "ca.pem")
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name) for name in names])
    builder = x509.CertificateBuilder(
        issuer.subject, subject, key.public_key(), 7, now - timedelta(days=1), now + timedelta(days=1)
    ).add_extension(x509.ExtendedKeyUsage([x509.ExtendedKeyUsageOID.CLIENT_AUTH]), critical=False)
    certificate = builder.sign(read_key(authority / "ca.key.pem"), hashes.SHA256())
    made = KeyFolder(path=folder)
    folder.mkdir()
    made.certificate.write_bytes(certificate.public_bytes(serialization.Encoding.PEM))
    no_password = serialization.NoEncryption()
    made.key.write_bytes(key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, no_password))
    shutil.copy(authority / "ca.pem", made.authority)
    return made
