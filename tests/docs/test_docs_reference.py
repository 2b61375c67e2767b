"""Every public name has a docstring and is in the Python reference; generated pages are current."""

import inspect
import re
import subprocess
import sys
from importlib import import_module

import pytest
from pages import DOCS, ROOT, text_of

import passafe

REFERENCE = DOCS / "reference"
DECISION_PARTS = "passafe.decision_schema"
MODULES = [DECISION_PARTS] + [
    name
    for page in ("python-protocol.md", "python-services.md")
    for name in re.findall(r"^::: (\S+)", text_of(REFERENCE / page), flags=re.MULTILINE)
]


def test_every_name_of_the_core_is_in_the_reference() -> None:
    page = text_of(REFERENCE / "python-core.md")
    shown = re.findall(r"^::: (\S+)$", page, flags=re.MULTILINE)

    assert DECISION_PARTS in shown
    assert sorted(name.rpartition(".")[2] for name in shown if name != DECISION_PARTS) == sorted(passafe.__all__)


@pytest.mark.parametrize("name", passafe.__all__)
def test_name_of_the_core_has_a_docstring(name: str) -> None:
    _require_docstrings(name, getattr(passafe, name))


@pytest.mark.parametrize("name", MODULES)
def test_module_of_the_reference_is_documented(name: str) -> None:
    module = import_module(name)

    assert module.__doc__
    for member, value in vars(module).items():
        if not member.startswith("_") and getattr(value, "__module__", None) == name:
            _require_docstrings(f"{name}.{member}", value)


def test_generated_pages_are_current() -> None:
    command = [sys.executable, str(ROOT / "docs_build" / "reference.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 0, done.stderr


def _require_docstrings(name: str, value: object) -> None:
    """Require a docstring of a class or function, and of a class's own public methods and properties."""
    if not (inspect.isclass(value) or inspect.isfunction(value)):
        return
    assert inspect.getdoc(value), name
    if inspect.isclass(value):
        for member, method in vars(value).items():
            if not member.startswith("_") and (inspect.isfunction(method) or isinstance(method, property)):
                assert inspect.getdoc(method) or inspect.getdoc(getattr(value, member)), f"{name}.{member}"
