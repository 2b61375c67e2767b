"""The glossary's terms are in order, complete and in use."""

import re

import pytest
from pages import DOCS, PAGES, ROOT, text_of

GLOSSARY = DOCS / "glossary.md"
SOURCES = ("passafe", "protocol", "services", "dashboard")
TABLES = re.findall(r"^\| term \|.*\n\|[-|]+\n((?:\|.*\n)+)", text_of(GLOSSARY), flags=re.MULTILINE)
ROWS = [[cell.strip() for cell in line.strip("|").split("|")] for table in TABLES for line in table.splitlines()]


def _used() -> str:
    pages = [text_of(page) for page in PAGES if page != GLOSSARY]
    code = [
        path.read_text(encoding="utf-8")
        for folder in SOURCES
        for path in sorted((ROOT / folder).rglob("*"))
        if path.suffix in {".py", ".proto", ".toml"}
    ]
    return _words("\n".join(pages + code))


def _words(text: str) -> str:
    """Return text in lower case, with identifiers taken apart and nothing but words."""
    return " ".join(re.sub(r"(?<=[a-z])(?=[A-Z])|[_\W]+", " ", text).lower().split())


@pytest.fixture(scope="module")
def used() -> str:
    return _used()


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_term_has_a_meaning_and_is_used(row: list[str], used: str) -> None:
    term, _, meaning, _ = row
    assert meaning
    assert re.search(rf"\b{_words(term)}", used), f"nobody uses {term!r}"


def test_terms_are_defined_once_and_in_order() -> None:
    terms = [row[0] for row in ROWS]

    assert len(set(terms)) == len(terms)
    assert len(terms) > 60
