"""Golden logs: small logs of different loops, with which a change of any decision is noticed.

``make golden`` makes them anew: `python tests/golden/golden_logs.py`.
"""

import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from mcap.records import Channel, Message, Metadata
from passafe_services.log.checkpoint import CHECKPOINT_RECORD, SIGNER_RECORD
from passafe_services.log.log_files import RECORDING_RECORD
from passafe_services.log.log_reader import LogReader
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.info import versions
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of

FOLDER: Final = Path(__file__).parent
RATE_HZ: Final = 125.0
ROUTER_PORT: Final = 7493

BAD_LINKS: Final[Mapping[str, Any]] = {
    "links.operator-to-filter": {"delay_s": 0.05, "jitter_s": 0.02, "loss": 0.1, "seed": 3},
    "links.filter-to-plant": {"delay_s": 0.01, "jitter_s": 0.02, "loss": 0.1, "corrupt": 0.02, "seed": 4},
    "links.plant-to-filter": {"delay_s": 0.02, "jitter_s": 0.03, "loss": 0.1, "duplicate": 0.1, "seed": 5},
}

SIMULATED: Final[Mapping[str, tuple[str, Mapping[str, Any]]]] = {
    "reference": ("notomista-cai-2020", {"duration_s": 0.7}),
    "reference-off": ("notomista-cai-2020", {"duration_s": 0.6, "filter.mode": "off"}),
    "bad-links": ("human-steers", {"duration_s": 0.7, **BAD_LINKS}),
    "planned-outage": (
        "walls-and-disks",
        {
            "duration_s": 0.4,
            "links.plant-to-filter": {"delay_s": 0.02, "rate_hz": 80.0, "queue": 4},
            "link_changes": [{"at_s": 0.3, "link": "filter-to-plant", "settings": {"delay_s": 0.1, "loss": 0.3}}],
        },
    ),
    "unpredicted": (
        "notomista-cai-2020",
        {"duration_s": 0.6, "filter.prediction": False, "links.plant-to-filter": {"delay_s": 0.05}},
    ),
    "two-robots": ("two-robots", {"duration_s": 0.5}),
}
"""Scenario and what is changed in it, by name of the log."""

LIVE: Final[Mapping[str, Sequence[str]]] = {
    "live": ("--duration", "0.3"),
    "live-bad-links": (
        "--duration", "0.2",
        "--link", "filter-to-plant:delay=0.03,jitter=0.02,loss=0.1",
        "--link", "plant-to-filter:delay=0.03,jitter=0.02,loss=0.1",
        "--link", "operator-to-filter:delay=0.05,loss=0.05",
    ),
}  # fmt: skip
"""Options of ``passafe demo``, by name of the log."""


def simulate(name: str, target: Path) -> None:
    """Write the log of a loop in virtual time."""
    scenario_name, changes = SIMULATED[name]
    scenario = load_scenario(scenario_name, {"rate_hz": RATE_HZ, **changes})
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions=versions(), driver="lockstep")
    with LogWriter(target, metadata) as writer:
        loop = lockstep_loop(scenario, LockstepLog(writer))
        loop.run(steps_of(scenario))
        loop.finish()


def run_live(name: str, target: Path) -> None:
    """Write the log of a demo."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--headless", "--rate", str(RATE_HZ)]
        command += ["--router-port", str(ROUTER_PORT), "--out", folder, *LIVE[name]]
        subprocess.run(command, check=True)
        [log] = Path(folder).glob("*.mcap")
        rewrite(log, target)


def rewrite(source: Path, target: Path) -> None:
    """Write a log in one chunk: a recorder that flushes for safety makes it half as large again.

    It is a recording of its own: what the source says of its files and checkpoints is not true of it.
    """
    metadata = {
        record.name: record.metadata
        for record in LogReader(source).records()
        if isinstance(record, Metadata) and record.name not in {CHECKPOINT_RECORD, RECORDING_RECORD, SIGNER_RECORD}
    }
    keys: dict[int, str] = {}
    with LogWriter(target, metadata) as writer:
        for record in LogReader(source).records():
            if isinstance(record, Channel):
                keys[record.id] = record.topic
            elif isinstance(record, Message):
                writer.write(keys[record.channel_id], record.data, sequence=record.sequence, wall_ns=record.log_time)


def main() -> int:
    """Make every golden log anew."""
    for name in SIMULATED:
        simulate(name, FOLDER / f"{name}.mcap")
    for name in LIVE:
        run_live(name, FOLDER / f"{name}.mcap")
    for path in sorted(FOLDER.glob("*.mcap")):
        sys.stdout.write(f"{path.name} {path.stat().st_size / 1e3:.1f} kB\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
