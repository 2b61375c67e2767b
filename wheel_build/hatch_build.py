"""Compiles what a tick runs through into the wheel, where that is asked for (``make wheel``); else a wheel is plain.

From the same sources: mypyc turns the modules that ``pyproject.toml`` lists into extension modules. Where the compiler
is GCC, loops that run tell it first which ways are gone often: a tick's code is larger than the processor's first
cache, and laid out by that it takes a tenth less time (``docs/decisions/0012-compiled-wheel.md``).
"""

import os
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

EXACT = "" if os.name == "nt" else "-ffp-contract=off"
"""No product and sum in one rounding: results are those of the interpreter, to the last bit. MSVC needs no telling."""

IN_LINE = "-fno-semantic-interposition"
"""No call within the module that somebody might redirect; before and after training, or the code is not the same."""

WATCHED = f"{IN_LINE} -fprofile-generate -fprofile-update=single"
TRAINED = f"{IN_LINE} -fprofile-use -fprofile-partial-training -Wno-missing-profile -flto=auto"

LINK = "delay=0.1,jitter=0.02,loss=0.1"
TRAINING = ["benchmarks/lockstep_speed.py", "--repetitions", "1", "--rate", "500"]
TRAINING += ["--link", f"plant-to-filter:{LINK}", "--link", f"filter-to-plant:{LINK}"]
"""A loop over a bad network, in every mode."""


class CompiledModules(BuildHookInterface):  # type: ignore[type-arg]  # the wheel's own configuration is not read
    """Hatchling's hook of a build."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile a copy, so that nothing compiled is left beside sources that are still being edited.

        Args:
            version: ``editable`` or ``standard``.
            build_data: Receives what goes into the wheel.
        """
        if version == "editable":
            return
        root = Path(self.root)
        folder = root / ".build" / "compiled"
        self._copy_to(folder)
        if self.config["trained"] and is_gcc():
            profile = f"-fprofile-dir={folder / 'profile'}"
            self._compile(folder, f"{WATCHED} {profile}")
            run(root, *TRAINING, PYTHONPATH=str(folder))
            for path in compiled(folder):
                path.unlink()
            self._compile(folder, f"{TRAINED} {profile}")
        else:
            self._compile(folder, "")
        require_same_bytes(root, folder)
        build_data["force_include"] |= {str(path): str(path.relative_to(folder)) for path in compiled(folder)}
        build_data |= {"pure_python": False, "infer_tag": True, "dependencies": ["mypy-extensions>=1"]}

    def _copy_to(self, folder: Path) -> None:
        """Copy the sources, with records that can be compiled."""
        root = Path(self.root)
        shutil.rmtree(folder, ignore_errors=True)
        for package in self.build_config.packages:
            shutil.copytree(root / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
        # mypyc builds with setuptools, which must not take this for a project of its own.
        shutil.copy(root / "pyproject.toml", folder / "mypy.toml")
        run(folder, str(root / "wheel_build" / "native_records.py"), *self.config["modules"])

    def _compile(self, folder: Path, flags: str) -> None:
        # What `make check` has to be told to ignore on Python 3.11 need not be there on a newer one.
        options = ["--config-file=mypy.toml", "--no-warn-unused-ignores"]
        shutil.rmtree(folder / "build", ignore_errors=True)  # what another call has left, compiled with other flags
        given = f"{sysconfig.get_config_var('CFLAGS') or ''} {os.environ.get('CFLAGS', '')}"
        environment = {"CFLAGS": f"{given} {EXACT} {flags}", "MYPYC_DEBUG_LEVEL": "0"}
        run(folder, "-m", "mypyc", *options, *self.config["modules"], **environment)


def run(folder: Path, *command: str, **environment: str) -> str:
    """Run this interpreter in a folder; return what it prints."""
    return subprocess.run(  # noqa: S603 - our own scripts, and mypyc
        [sys.executable, *command],
        cwd=folder,
        env=os.environ | environment,
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    ).stdout


def require_same_bytes(root: Path, folder: Path) -> None:
    """Refuse modules whose loops do not send what those of the sources do.

    Raises:
        ValueError: They do not.
    """
    got, allowed = (run(root, "tests/system/lockstep_digest.py", PYTHONPATH=str(path)) for path in (folder, root))
    if got != allowed:
        raise ValueError(f"what compiled loops send: got {got}, allowed {allowed}, as from the sources")


def compiled(folder: Path) -> list[Path]:
    """Return the extension modules in a folder, those that mypyc has put in place."""
    found = [path for kind in ("*.so", "*.pyd") for path in folder.rglob(kind)]
    return [path for path in found if path.relative_to(folder).parts[0] != "build"]


def is_gcc() -> bool:
    """Whether extension modules are compiled by GCC, whose options ``WATCHED`` and ``TRAINED`` are."""
    compiler = sysconfig.get_config_var("CC")
    if compiler is None:
        return False
    told = subprocess.run([compiler.split()[0], "--version"], capture_output=True, text=True, check=False)  # noqa: S603
    return "Free Software Foundation" in told.stdout
