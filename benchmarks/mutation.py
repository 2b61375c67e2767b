"""Tests whether every sign, row and gain of the core is guarded by a test.

``python benchmarks/mutation.py`` copies the tree, changes one thing at a time in the core
(``core_changes.py``) and runs the core's tests on it until one fails: those that noticed earlier changes of the same
file, are named after it or import it first, then the others, the quickest first. A change that no test notices survives
and is listed; the exit code then is 1. Findings are written as they come, and the same command resumes where it was
interrupted. A change is tried again when its file has changed, or the tests that noticed it; one that survived,
when any have.
"""

import ast
import json
import re
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from functools import cache
from hashlib import sha256
from pathlib import Path
from queue import SimpleQueue
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Annotated, Any, Final

import typer
from core_changes import EQUIVALENT, FILES, ROOT, Change, changes_of
from core_copy import NO_END, Copy
from report import Smallest
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

TESTS: Final = ROOT / "tests" / "core"
LONGEST_S: Final = 3600.0
"""Longest time of one file of tests without a change."""


class Findings:
    """Outcome of every change, kept in a file, a line each.

    Attributes:
        seconds: What each file of tests takes without a change.
        noticed_by: By the key of the change: the test that noticed it, or an empty string.
    """

    def __init__(self, path: Path) -> None:
        """Read what is known about the present tests."""
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = path
        self.seconds: dict[str, float] = {}
        self.noticed_by: dict[str, str] = {}
        self._guards: Counter[tuple[str, str]] = Counter()
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        for line in lines:
            if line.endswith("}"):  # else it was interrupted there
                self._learn(json.loads(line))

    def add(self, finding: dict[str, Any]) -> None:
        """Write down one finding and take it into account from now on."""
        found = {"tests": _digest(_test_of(finding))} | finding
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(found, ensure_ascii=False) + "\n")
        self._learn(found)

    def order(self, file: str) -> list[str]:
        """Return the files of tests: first those that are of one of the core's files, of these the quickest first.

        A file that noticed earlier changes is worth waiting for that many times as long.
        """
        stem = Path(file).stem

        def rank(test: str) -> tuple[bool, float]:
            guarded = self._guards[file, test]
            is_of_it = guarded > 0 or stem in test or _imports(TESTS / test, stem)
            return not is_of_it, self.seconds[test] / (1 + guarded)

        return sorted(self.seconds, key=rank)

    def _learn(self, found: dict[str, Any]) -> None:
        test = _test_of(found)
        if found["tests"] != _digest(test):
            return
        if "seconds" in found:
            self.seconds[test] = found["seconds"]
            return
        self.noticed_by[found["key"]] = found["noticed_by"]
        if test:
            self._guards[found["key"].split(":")[0], test] += 1


def main(
    only: Annotated[str, typer.Option(help="File of the core; all of it if not given.")] = "",
    every: Annotated[int, typer.Option(min=1, help="Try every so many-th change only.")] = 1,
    workers: Annotated[int, typer.Option(min=1, help="Changes tried at a time.")] = 2,
    findings: Annotated[Path, typer.Option(help="File of what was found.")] = ROOT / "runs" / "mutation.jsonl",
    tests: Annotated[str, typer.Option(help="Files of the core's tests, as a pattern.")] = "test_*.py",
    show: Annotated[bool, typer.Option("--list", help="List the changes and try none.")] = False,
    smallest: Smallest = False,
) -> None:
    """Change the core, one thing at a time, and list the changes that no test notices."""
    if smallest:
        only, tests, every, workers = "tank.py", "test_tank.py", 1000, 1
    console = Console(width=120, highlight=False)
    changes = selected_changes(only, every)
    if show:
        for change in changes:
            console.print(f"{change.file}:{change.line} {change.words}{' (equivalent)' * change.is_equivalent}")
        raise typer.Exit
    asked = [change for change in changes if not change.is_equivalent]
    with TemporaryDirectory() as folder:
        found = Findings(Path(folder) / "findings.jsonl" if smallest else findings)
        copies: SimpleQueue[Copy] = SimpleQueue()
        for k in range(workers):
            copies.put(Copy.into(Path(folder) / f"{k}"))
        time_tests(tests, found, copies, workers)
        try_all([change for change in asked if change.key not in found.noticed_by], found, copies, workers)
    noticed = [found.noticed_by[change.key] for change in asked]
    survivors = [change for change, test in zip(asked, noticed, strict=True) if not test]
    console.print(
        f"{len(asked)} changes, {len(asked) - len(survivors)} noticed, {noticed.count(NO_END)} of them by tests "
        f"without an end; {len(changes) - len(asked)} others change nothing that can be seen"
    )
    for change in survivors:
        console.print(f"survived: {change.file}:{change.line} {change.words}")
    raise typer.Exit(1 if survivors else 0)


def selected_changes(only: str, every: int) -> list[Change]:
    """Return every so many-th change of one file of the core, of all of them for an empty name.

    Raises:
        SystemExit: Changes are listed as equivalent that there are not.
    """
    every_change = [change for file in FILES for change in changes_of(file)]
    stale = EQUIVALENT.keys() - {(change.scope, change.words) for change in every_change}
    if stale:
        raise SystemExit(f"EQUIVALENT: got {sorted(stale)}, allowed changes that there are")
    return [change for change in every_change if change.file == (only or change.file)][::every]


def time_tests(pattern: str, found: Findings, copies: "SimpleQueue[Copy]", workers: int) -> None:
    """Measure how long every file of tests takes, and that it passes, without a change."""
    files = (str(file.relative_to(TESTS)) for file in sorted(TESTS.rglob(pattern)))
    unknown = [file for file in files if file not in found.seconds]

    def timed(test: str) -> tuple[str, str, float]:
        where, start_s = copies.get(), perf_counter()
        try:
            failing = where.failing([test], LONGEST_S)
        finally:
            copies.put(where)
        return test, failing, perf_counter() - start_s

    with progress() as bar, ThreadPoolExecutor(workers) as pool:
        task = bar.add_task("tests without a change", total=len(unknown))
        for test, failing, seconds in pool.map(timed, unknown):
            if failing:
                raise SystemExit(f"tests/core: {failing} fails without a change")
            found.add({"file": test, "seconds": round(seconds, 2)})
            bar.advance(task)


def try_all(changes: Sequence[Change], found: Findings, copies: "SimpleQueue[Copy]", workers: int) -> None:
    """Try changes and write down what became of each."""

    def tried(change: Change) -> tuple[Change, str, float]:
        where, start_s = copies.get(), perf_counter()
        try:
            noticed = where.noticed_by(change, found.order(change.file), found.seconds)
        finally:
            copies.put(where)
        return change, noticed, perf_counter() - start_s

    pool = ThreadPoolExecutor(workers)
    try:
        with progress() as bar:
            survived = 0
            task = bar.add_task("changes", total=len(changes))
            for done in as_completed([pool.submit(tried, change) for change in changes]):
                change, noticed, seconds = done.result()
                found.add({"key": change.key, "noticed_by": noticed, "took_s": round(seconds, 1)})
                survived += not noticed
                bar.update(task, advance=1, description=f"changes, {survived} survived")
    finally:
        pool.shutdown(cancel_futures=True)


def progress() -> Progress:
    """Return a bar with the time that is left."""
    return Progress(TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())


def _test_of(found: dict[str, Any]) -> str:
    """Return the file of tests that a finding is about, an empty string if it is about all of them."""
    named = re.match(r"(\w+/)*test_\w+\.py", found.get("file", found.get("noticed_by", "")))
    return named[0] if named else ""


@cache
def _digest(test: str) -> str:
    """Return a digest of one file of tests, of all of them for an empty string, and of what tests share."""
    digest = sha256()
    for file in sorted(TESTS.rglob("*.py")):
        if str(file.relative_to(TESTS)) == test or not test or not file.name.startswith("test_"):
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _imports(test: Path, module: str) -> bool:
    """Return whether a test imports a module of the core, by its last name."""
    nodes = ast.walk(ast.parse(test.read_text(encoding="utf-8")))
    named = [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    return any(name.startswith("passafe.") and name.endswith(f".{module}") for name in named)


if __name__ == "__main__":
    typer.run(main)
