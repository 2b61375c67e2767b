"""``passafe review --verify`` at the terminal and as JSON."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from passafe_protocol.identity import Identity
from passafe_services.cli.app import app
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.deployment import Deployment
from passafe_services.keys.signing import Signer
from passafe_services.log.chain import Chain
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop
from typer.testing import CliRunner


class LogOfNow(LogWriter):
    """Log whose messages have the time at which the keys are valid; that of a run in virtual time is another."""

    def write(self, key: str, data: bytes, *, sequence: int, wall_ns: int) -> None:
        """Log one message."""
        super().write(key, data, sequence=sequence, wall_ns=wall_ns % 1_000_000_000 + time.time_ns())


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    folder = tmp_path / "keys"
    Deployment.create(folder).issue([Identity(role="recorder", robot="robot")])
    return folder


@pytest.fixture
def record(tmp_path: Path, keys: Path) -> Callable[[bool], Path]:
    """Return a function that records 0.2 s of a run, signed or not."""

    def written(signed: bool) -> Path:
        scenario = load_scenario("notomista-cai-2020", {"rate_hz": 200.0, "filter.k_i": 50.0, "plant.hold_s": 0.01})
        metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
        signer = Signer.of(load_credentials(keys, "recorder", "robot")) if signed else None
        with LogOfNow(tmp_path / "run.mcap", metadata, chain=Chain("a run", signer)) as log:
            loop = lockstep_loop(scenario, observer=LockstepLog(log))
            loop.run(40)
            loop.finish()
        return tmp_path / "run.mcap"

    return written


def test_a_log_without_signatures_is_not_verified(record: Callable[[bool], Path]) -> None:
    result = CliRunner().invoke(app, ["review", str(record(False)), "--verify"])
    assert result.exit_code == 1
    assert "doubt     it is not signed" in result.output
    assert "not verified: " in result.output


def test_the_authority_may_be_named(record: Callable[[bool], Path], keys: Path) -> None:
    path = record(True)
    own = CliRunner().invoke(app, ["review", str(path), "--verify"])
    assert "the authority is the log's own word" in own.output
    pinned = CliRunner().invoke(app, ["review", str(path), "--authority", str(keys / "authority" / "ca.pem"), "--json"])
    verification = json.loads(pinned.output)["verification"]
    assert (verification["holds"], verification["is_pinned"]) == (True, True)
    assert (verification["signer"], verification["found"], verification["doubts"]) == ("recorder.robot", [], [])


def test_an_authority_that_is_none_is_refused(record: Callable[[bool], Path], tmp_path: Path) -> None:
    missing = CliRunner().invoke(app, ["review", str(record(True)), "--authority", str(tmp_path / "none.pem")])
    assert missing.exit_code != 0
    assert missing.exception is not None
    assert "got no such file" in str(missing.exception)
