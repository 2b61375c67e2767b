"""The files, modules and pages that pages name exist."""

import re
from importlib.util import find_spec
from pathlib import Path

import pytest
from pages import PAGES, ROOT, name_of, text_of
from passafe_protocol.topics import PROCESSES

FOLDERS = ("passafe", "protocol", "services", "dashboard", "docs", "examples", "benchmarks", "tests", "wheel_build")
PATH = re.compile(rf"(?<![\w/.])((?:{'|'.join(FOLDERS)})/[\w./-]*\w)/?")
KEY_EXPRESSION = re.compile(rf"passafe/[a-z0-9-]+/(\*|{'|'.join(PROCESSES)})/\w+")
MODULE = re.compile(r"(?:`|^::: )(passafe(?:_\w+)?(?:\.\w+)+)", re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_paths_named_exist(page: Path) -> None:
    named = [path for code in re.findall(r"`[^`\n]+`", text_of(page)) for path in PATH.findall(code)]

    named = [path for path in named if not KEY_EXPRESSION.fullmatch(path)]
    missing = [path for path in named if not (ROOT / path).exists() and not (ROOT / f"{path}.py").exists()]

    assert not missing


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_dotted_names_exist(page: Path) -> None:
    for name in set(MODULE.findall(text_of(page))) - {"passafe.proto", "passafe.v1", "passafe.drivers"}:
        module, parts = name, []
        while not _is_module(module):
            module, _, last = module.rpartition(".")
            parts.insert(0, last)
            assert module, name
        found: object = __import__(module, fromlist=["_"])
        for part in parts:
            assert hasattr(found, part), name
            found = getattr(found, part)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_to_files(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text_of(page)):
        assert (page.parent / target).exists(), target


def _is_module(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:
        return False
