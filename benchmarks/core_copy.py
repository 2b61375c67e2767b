"""Copies the core and its tests, makes one change at a time there and tries it.

Tests run in children of a server that has imported the large libraries, though nothing of the core: reading them is
most of what a few tests take.
"""

import os
import re
import sys
from collections.abc import Mapping, Sequence
from compileall import compile_dir
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from py_compile import PycInvalidationMode
from resource import RLIMIT_AS, setrlimit
from shutil import copy, copytree
from signal import SIGABRT, SIGSEGV
from typing import Final

import pytest
from core_changes import ROOT, Change

LIKELY: Final = 8
"""Files of tests that are tried first, in a run of their own: collecting all of them takes seconds."""

PATIENCE: Final = 10.0
PATIENCE_S: Final = 120.0
"""So many times as long as without a change, and so much longer, tests may take; then the change was noticed, too."""

MOST_MEMORY: Final = 6 * 2**30
"""Bytes of address space for a run of tests, several times what they need: a loop without an end may fill memory."""

NO_END: Final = "no end"
"""Stands for the test that noticed a change where tests took too long."""

NO_MEMORY: Final = 127
"""Exit code of the system's loader where it gets no memory."""

CRASHED: Final = frozenset({pytest.ExitCode.INTERNAL_ERROR, NO_MEMORY, -SIGSEGV, -SIGABRT})
"""Exit codes that stand for a change that was noticed although no test is named; others do not judge the change."""

_children = get_context("forkserver")
_children.set_forkserver_preload(["__main__", "casadi", "daqp", "piqp", "scipy.integrate", "scipy.optimize"])


@dataclass(frozen=True, kw_only=True)
class Copy:
    """A copy of what the core's tests need.

    Attributes:
        where: Its folder.
    """

    where: Path

    @classmethod
    def into(cls, where: Path) -> "Copy":
        """Make one."""
        for part in ("passafe", "tests/core", "tests/conftest.py", "pyproject.toml"):
            source, target = ROOT / part, where / part
            target.parent.mkdir(parents=True, exist_ok=True)
            copytree(source, target) if source.is_dir() else copy(source, target)
        # By content, not by time: a change is made, undone and followed by another within a second.
        compile_dir(where / "passafe", force=True, quiet=1, invalidation_mode=PycInvalidationMode.CHECKED_HASH)
        return cls(where=where)

    def failing(self, tests: Sequence[str], timeout_s: float) -> str:
        """Return what fails first, or an empty string if all of them pass."""
        file = self.where / "output.txt"
        file.write_text("", encoding="utf-8")
        child = _children.Process(target=_run, args=(self.where, tests, file))
        child.start()
        child.join(timeout_s)
        if child.is_alive():
            child.kill()
            child.join()
            return NO_END
        if child.exitcode == 0:
            return ""
        output = file.read_text(encoding="utf-8")
        named = re.search(r"^(?:FAILED|ERROR) (\S+)", output, re.MULTILINE)
        if named:
            return named[1].removeprefix("tests/core/")
        if child.exitcode in CRASHED:
            return f"exit code {child.exitcode}"
        raise SystemExit(f"pytest: got exit code {child.exitcode} and no test that failed\n{output}")

    def noticed_by(self, change: Change, order: Sequence[str], seconds: Mapping[str, float]) -> str:
        """Return what fails first when a change is made, an empty string if nothing does.

        Args:
            change: What is changed; undone again afterwards.
            order: Files of tests, the likeliest to fail first.
            seconds: What each of them takes without a change.
        """
        path = self.where / "passafe" / change.file
        before = path.read_text(encoding="utf-8")
        path.write_text(change.text, encoding="utf-8")
        try:
            for tests in (order[:LIKELY], order[LIKELY:]):
                usual_s = sum(seconds[test] for test in tests)
                noticed = self.failing(tests, PATIENCE * usual_s + PATIENCE_S)
                if noticed:
                    return noticed
        finally:
            path.write_text(before, encoding="utf-8")
        return ""


def _run(where: Path, tests: Sequence[str], output: Path) -> None:
    """Run tests in this process, which is a child, and end it with pytest's exit code."""
    setrlimit(RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    os.chdir(where)
    sys.path[:] = [str(where), *(path for path in sys.path if path != str(Path(__file__).parent))]
    sys.dont_write_bytecode = True
    descriptor = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    sys.exit(int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *(f"tests/core/{test}" for test in tests)])))
