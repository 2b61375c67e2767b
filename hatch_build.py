"""Compiles what a tick runs through into the wheel, where that is asked for (``make wheel``); else a wheel is plain.

The same sources, nothing else: mypyc turns the modules that ``pyproject.toml`` lists into extension modules.
"""

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


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
        root, modules = Path(self.root), self.config["modules"]
        folder = root / ".build" / "compiled"
        shutil.rmtree(folder, ignore_errors=True)
        for package in self.build_config.packages:
            shutil.copytree(root / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
        # mypyc builds with setuptools, which must not take this for a project of its own.
        shutil.copy(root / "pyproject.toml", folder / "mypy.toml")
        # What `make check` has to be told to ignore on Python 3.11 need not be there on a newer one.
        options = ["--config-file=mypy.toml", "--no-warn-unused-ignores"]
        command = [sys.executable, "-m", "mypyc", *options, *modules]
        subprocess.run(command, cwd=folder, check=True)  # noqa: S603 - the modules are this project's
        for kind in ("*.so", "*.pyd"):
            found = [path.relative_to(folder) for path in folder.rglob(kind)]
            build_data["force_include"] |= {str(folder / path): str(path) for path in found if path.parts[0] != "build"}
        build_data |= {"pure_python": False, "infer_tag": True}
