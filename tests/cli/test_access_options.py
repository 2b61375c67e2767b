"""Keys of a process on the command line: those that expire soon are named."""

from pathlib import Path

import pytest
from passafe_protocol.identity import Identity
from passafe_services.cli.access_options import secured_endpoint
from passafe_services.keys.deployment import Deployment
from passafe_services.loop.process_name import ProcessName


@pytest.mark.parametrize(("days", "quiet", "said"), [(29.0, False, True), (29.0, True, False), (90.0, False, False)])
def test_keys_that_expire_soon_are_named(
    days: float, quiet: bool, said: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    identity = Identity(role="filter", robot="left-arm")
    folder = tmp_path / "keys"
    Deployment.create(folder).issue([identity], days=days)

    endpoint = secured_endpoint(
        "127.0.0.1:7447", ProcessName.FILTER, "left-arm", keys=folder, insecure=False, quiet=quiet
    )

    assert endpoint.credentials is not None
    assert ("expires in" in capsys.readouterr().err) is said
