"""Compiles the modules that ``pyproject.toml`` lists into the wheel (``make wheel``); other builds stay plain."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SAME_ROUNDING = "" if os.name == "nt" else "-ffp-contract=off"
"""Forbids fused multiply-add, which rounds once where the interpreter rounds twice; MSVC does not fuse unasked."""


class CompiledModules(BuildHookInterface):  # type: ignore[type-arg]  # the wheel's own configuration is not read
    """Hatchling's build hook that runs mypyc."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile a copy, laid out as the wheel is, so that no extension module shadows a source being edited.

        Args:
            version: ``editable`` or ``standard``.
            build_data: Receives the extension modules and the wheel's tags.
        """
        if version == "editable":
            return
        root = Path(self.root)
        folder = root / ".build" / "compiled"
        shutil.rmtree(folder, ignore_errors=True)
        for package in map(Path, self.build_config.packages):
            shutil.copytree(root / package, folder / package.name, ignore=shutil.ignore_patterns("__pycache__"))
        # A type-ignore that Python 3.11 needs may be superfluous on a newer one.
        options = ["--config-file", str(root / "pyproject.toml"), "--no-warn-unused-ignores"]
        flags = {"CFLAGS": f"{os.environ.get('CFLAGS', '')} {SAME_ROUNDING}", "MYPYC_DEBUG_LEVEL": "0"}
        command = [sys.executable, "-m", "mypyc", *options, *self.config["modules"]]
        subprocess.run(command, cwd=folder, env=os.environ | flags, check=True, stdout=subprocess.DEVNULL)  # noqa: S603 - mypyc
        shutil.rmtree(folder / "build")
        found = [path for kind in ("*.so", "*.pyd") for path in folder.rglob(kind)]
        build_data["force_include"] |= {str(path): str(path.relative_to(folder)) for path in found}
        build_data |= {"pure_python": False, "infer_tag": True}
