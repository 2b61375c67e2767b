"""Podman with storage, networks and settings of its own, for tests: what it makes is gone when the test ends."""

import json
import os
import resource
import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

NEEDED: Final = ("podman", "podman-compose", "runc", "debootstrap", "iptables")
"""Programs of the test, which are Debian packages of the same names; podman's networks need two more packages."""

PACKAGES: Final = (*NEEDED, "netavark", "aardvark-dns")

# runc with cgroupfs works without systemd and without a container engine's daemon.
_SETTINGS: Final = """
[engine]
runtime = "runc"
cgroup_manager = "cgroupfs"
events_logger = "file"
[network]
network_backend = "netavark"
network_config_dir = "{folder}/networks"
[containers]
default_ulimits = ["nofile={files}:{files}", "nproc={processes}:{processes}"]
"""
_STORAGE: Final = """
[storage]
driver = "overlay"
graphroot = "{folder}/storage"
runroot = "{folder}/run"
"""
_MOST: Final = 4096
"""Largest limit of open files and processes: that of the compose file."""


@dataclass(frozen=True, kw_only=True)
class PodmanHost:
    """Podman whose containers, images, networks and volumes are below one folder."""

    folder: Path

    def prepare(self) -> None:
        """Write its settings. Limits beyond the hard ones of this process would need a capability that it may lack."""
        for part in ("networks", "storage", "run"):
            (self.folder / part).mkdir(parents=True)
        files = _limit(resource.RLIMIT_NOFILE)
        settings = _SETTINGS.format(folder=self.folder, files=files, processes=_limit(resource.RLIMIT_NPROC))
        (self.folder / "containers.conf").write_text(settings, encoding="utf-8")
        (self.folder / "storage.conf").write_text(_STORAGE.format(folder=self.folder), encoding="utf-8")

    def run(
        self, *command: str, environment: Mapping[str, str] | None = None, cwd: Path | None = None, check: bool = True
    ) -> subprocess.CompletedProcess[str]:
        """Run podman, or podman-compose, with these settings."""
        own = {
            "CONTAINERS_CONF": str(self.folder / "containers.conf"),
            "CONTAINERS_STORAGE_CONF": str(self.folder / "storage.conf"),
        }
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            cwd=cwd,
            env=os.environ | own | dict(environment or {}),
        )
        assert not check or done.returncode == 0, f"{command}:\n{done.stdout}{done.stderr}"
        return done

    def inspect(self, container: str) -> dict[str, Any]:
        """Return what podman knows of a container."""
        [found] = json.loads(self.run("podman", "inspect", container).stdout)
        return dict(found)

    def remove(self) -> None:
        """Remove every container, image, network and volume, and the folder."""
        self.run("podman", "rm", "--all", "--force", "--time", "1", check=False)
        self.run("podman", "network", "prune", "--force", check=False)
        self.run("podman", "rmi", "--all", "--force", check=False)
        self.run("podman", "unmount", "--all", check=False)
        shutil.rmtree(self.folder, ignore_errors=True)


def _limit(kind: int) -> int:
    _, hard = resource.getrlimit(kind)
    return _MOST if hard == resource.RLIM_INFINITY else min(hard, _MOST)
