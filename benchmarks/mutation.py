"""Is every sign, row and gain of the core guarded by a test?

``python benchmarks/mutation.py`` copies the tree, changes one thing at a time in the core's mathematics and runs the
core's tests on it: a plus for a minus, a minus sign left out, a row left out, a gain or a period halved, a least for a
largest. A change that no test notices survives and is listed; the exit code then is 1. Ten to sixty seconds a change.
"""

import ast
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Final

import typer
from rich.console import Console
from rich.progress import track

ROOT: Final = Path(__file__).resolve().parents[1]
FILES: Final = (
    "barrier.py",
    "between_samples.py",
    "class_k.py",
    "derivation.py",
    "enclosure.py",
    "limits.py",
    "passivity.py",
    "quadratic_program.py",
    "rows.py",
    "tank.py",
    "tracking.py",
)
GAINS: Final = frozenset({"gain", "gain_below", "k_i", "dt_s", "rate_per_s", "reserve_j", "slack_price", "norm"})
SWAPPED: Final = {"fmin": "fmax", "fmax": "fmin", "mmax": "mmin", "mmin": "mmax", "min": "max", "max": "min"}
TIMEOUT_S: Final = 240


@dataclass(frozen=True, kw_only=True)
class Mutation:
    """One change of one file.

    Attributes:
        file: Name of the core's file.
        line: Where, from 1.
        what: In words.
        text: The whole file with the change.
    """

    file: str
    line: int
    what: str
    text: str


def main(
    only: Annotated[str, typer.Option(help="File of the core; all of the mathematics if not given.")] = "",
    every: Annotated[int, typer.Option(min=1, help="Try every so many-th change only.")] = 1,
    workers: Annotated[int, typer.Option(min=1, help="Changes tried at a time.")] = 2,
    show: Annotated[bool, typer.Option("--list", help="List the changes and try none.")] = False,
) -> None:
    """Change the core, one thing at a time, and list the changes that no test notices."""
    files = [only] if only else list(FILES)
    mutations = [mutation for file in files for mutation in mutations_of(file)][::every]
    console = Console(width=120)
    if show:
        for mutation in mutations:
            console.print(f"{mutation.file}:{mutation.line} {mutation.what}", highlight=False)
        raise typer.Exit
    with TemporaryDirectory() as folder, ThreadPoolExecutor(workers) as pool:
        copies = [copy_tree(Path(folder) / f"{k}") for k in range(workers)]
        tried = pool.map(lambda pair: notices(copies, *pair), enumerate(mutations))
        noticed = list(track(tried, description="trying", total=len(mutations), console=console))
    survivors = [mutation for mutation, seen in zip(mutations, noticed, strict=True) if not seen]
    console.print(f"{len(mutations)} changes, {len(mutations) - len(survivors)} noticed")
    for mutation in survivors:
        console.print(f"survived: {mutation.file}:{mutation.line} {mutation.what}", highlight=False)
    raise typer.Exit(1 if survivors else 0)


def copy_tree(where: Path) -> Path:
    """Copy what the core's tests need."""
    for part in ("passafe", "tests/core", "tests/conftest.py", "pyproject.toml"):
        source, target = ROOT / part, where / part
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(source, target) if source.is_dir() else shutil.copy(source, target)
    return where


def notices(copies: list[Path], number: int, mutation: Mutation) -> bool:
    """Tell whether the core's tests fail on a changed tree."""
    where = copies[number % len(copies)]
    path = where / "passafe" / mutation.file
    before = path.read_text(encoding="utf-8")
    path.write_text(mutation.text, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "tests/core"]
    try:
        done = subprocess.run(  # noqa: S603 - our own tests
            command, cwd=where, capture_output=True, check=False, timeout=TIMEOUT_S
        )
    except subprocess.TimeoutExpired:
        return True
    finally:
        path.write_text(before, encoding="utf-8")
    return done.returncode != 0


def mutations_of(file: str) -> Iterator[Mutation]:
    """Yield every change of one file."""
    source = (ROOT / "passafe" / file).read_text(encoding="utf-8")
    lines = source.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.encode()))
    raw = source.encode()
    for node in ast.walk(ast.parse(source)):
        for what, replacement in changes(node):
            begin = starts[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]  # every one has a place
            end = starts[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
            text = (raw[:begin] + replacement.encode() + raw[end:]).decode()
            yield Mutation(file=file, line=node.lineno, what=what, text=text)  # type: ignore[attr-defined]


def changes(node: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield what may be put in the place of a node: words for it, and source."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        sign = "-" if isinstance(node.op, ast.Add) else "+"
        yield f"{ast.unparse(node)}: {sign}", f"({ast.unparse(node.left)} {sign} ({ast.unparse(node.right)}))"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub) and not isinstance(node.operand, ast.Constant):
        yield f"{ast.unparse(node)}: no minus", f"({ast.unparse(node.operand)})"
    if isinstance(node, ast.Attribute) and node.attr in GAINS and isinstance(node.ctx, ast.Load):
        yield f"{ast.unparse(node)}: halved", f"(0.5 * {ast.unparse(node)})"
    if isinstance(node, ast.Call):
        yield from _changes_of_call(node)


def _changes_of_call(node: ast.Call) -> Iterator[tuple[str, str]]:
    arguments = ", ".join(ast.unparse(argument) for argument in [*node.args, *node.keywords])
    if isinstance(node.func, ast.Attribute) and node.func.attr in SWAPPED:
        other = f"{ast.unparse(node.func.value)}.{SWAPPED[node.func.attr]}"
        yield f"{ast.unparse(node)}: {SWAPPED[node.func.attr]}", f"{other}({arguments})"
    if isinstance(node.func, ast.Attribute) and node.func.attr == "append":
        yield f"{ast.unparse(node)}: left out", "None"


if __name__ == "__main__":
    typer.run(main)
