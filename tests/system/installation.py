"""The wheel, installed into an environment of its own."""

import os
import subprocess
import sys
import venv
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import distribution, distributions
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[2]
PIP = (sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check")


@dataclass(frozen=True, kw_only=True)
class Installation:
    """An environment that holds the wheel."""

    folder: Path

    @property
    def python(self) -> Path:
        """Its interpreter."""
        return self.folder / "bin" / "python"

    @property
    def site(self) -> Path:
        """Its folder of packages."""
        [site] = self.folder.glob("lib/python3*/site-packages")
        return site

    def run(self, *command: str, cwd: Path, timeout_s: float = 120.0) -> subprocess.CompletedProcess[str]:
        """Run one of its scripts in a folder, without what this environment has set for Python."""
        ours = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
        return subprocess.run(
            [str(self.folder / "bin" / command[0]), *command[1:]],
            capture_output=True,
            text=True,
            cwd=cwd,
            env=ours,
            timeout=timeout_s,
            check=False,
        )


def built_wheel(folder: Path) -> Path:
    """Build the wheel into a folder; return it."""
    wheel = ("wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(folder), str(ROOT))
    subprocess.run([*PIP, *wheel], check=True)
    [built] = folder.glob("*.whl")
    return built


def linked_installation(folder: Path, wheel: Path, extra: str = "") -> Installation:
    """Install the wheel for this interpreter; link what it requires, and nothing else, from this environment."""
    venv.create(folder, symlinks=True)
    installed = Installation(folder=folder)
    pip = (*PIP, "--python", str(installed.python))
    subprocess.run([*pip, "install", "--no-deps", "--no-index", str(wheel)], check=True)
    [passafe] = (found for found in distributions(path=[str(installed.site)]) if found.name == "passafe")
    for name in closure(passafe.requires or (), extra):
        for entry in {Path(file).parts[0] for file in distribution(name).files or ()} - {"..", "__pycache__"}:
            target = installed.site / entry
            if not target.exists():
                target.symlink_to(Path(distribution(name).locate_file(entry)))
    return installed


def downloaded_installation(folder: Path, wheel: Path, interpreter: str, extra: str = "") -> Installation:
    """Install the wheel and what it requires, as pinned, from the package index, for any interpreter."""
    subprocess.run([interpreter, "-m", "venv", "--without-pip", str(folder)], check=True)
    installed = Installation(folder=folder)
    named = f"passafe{f'[{extra}]' if extra else ''} @ {wheel.as_uri()}"
    pip = (*PIP, "--python", str(installed.python))
    subprocess.run([*pip, "install", "--constraint", str(ROOT / "constraints.txt"), named], check=True)
    return installed


def closure(requirements: Iterable[str], extra: str) -> set[str]:
    """Return the names of the packages that requirements ask for, directly or through others, as installed here."""
    waiting = [(text, extra) for text in requirements]
    found: set[tuple[str, str]] = set()
    while waiting:
        text, asked = waiting.pop()
        requirement = Requirement(text)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": asked}):
            continue
        for one in {(requirement.name, each) for each in ("", *requirement.extras)} - found:
            found.add(one)
            waiting += [(inner, one[1]) for inner in distribution(requirement.name).requires or ()]
    return {name for name, _ in found}
