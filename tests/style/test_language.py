"""Rules of language that no linter checks: lengths of test names, first words of docstrings, unique class names."""

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
PACKAGES: Final = ("passafe", "protocol/passafe_protocol", "services/passafe_services", "dashboard/passafe_dashboard")
FOLDERS: Final = (*PACKAGES, "tests", "benchmarks", "examples", "wheel_build", "deploy")
LONGEST_TEST_NAME: Final = 60

QUESTION_WORDS: Final = frozenset(
    {"What", "How", "Whether", "Where", "Which", "Who", "Whom", "Whose", "When", "Why"}
    | {"That", "Those", "These", "Tell", "Tells", "Say", "Says", "It"}
)
"""First words of docstrings that describe neither an action nor a thing; ruff's D401 checks functions further."""

IGNORED: Final = re.compile(
    r"#\s*(?:type: ignore|noqa|pragma: no cover)(?:\[[\w, -]+\]|: [A-Z]+[0-9]+(?:, ?[A-Z]+[0-9]+)*)?(?P<rest>.*)"
)
"""A finding of a checker that is left out, and what is said about it."""

Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


@cache
def tree_of(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


def sources(*folders: str) -> Iterator[Path]:
    for folder in folders:
        yield from (path for path in sorted((ROOT / folder).rglob("*.py")) if not path.name.endswith("_pb2.py"))


def place(path: Path, node: ast.AST) -> str:
    return f"{path.relative_to(ROOT)}:{getattr(node, 'lineno', 1)}"


def test_test_names_are_short() -> None:
    long = [
        f"{place(path, node)}: {node.name}"
        for path in sources("tests")
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and node.name.startswith("test_")
        and len(node.name) > LONGEST_TEST_NAME
    ]

    assert not long, "\n".join(long)


def test_docstrings_begin_with_a_verb_or_a_noun() -> None:
    questions = []
    for path in sources(*FOLDERS):
        for node in ast.walk(tree_of(path)):
            text = ast.get_docstring(node) if isinstance(node, Documented) else None
            word = text.split(maxsplit=1)[0].rstrip(",:;.") if text else ""
            if word in QUESTION_WORDS:
                questions.append(f"{place(path, node)}: {word} …")

    assert not questions, "\n".join(questions)


def test_public_class_names_are_unique() -> None:
    classes = [
        (node.name, place(path, node))
        for path in sources(*PACKAGES)
        for node in tree_of(path).body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    ]
    counts = Counter(name for name, _ in classes)

    assert not [f"{at}: {name}" for name, at in classes if counts[name] > 1]


def test_what_a_checker_leaves_out_has_its_reason() -> None:
    bare = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in sources(*FOLDERS)
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if (found := IGNORED.search(line)) and not re.search(r"[A-Za-z]{2}", found["rest"])
    ]

    assert not bare, "\n".join(bare)
