"""The version is the same wherever it stands."""

import re
import tomllib

from pages import ROOT, text_of

VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


def test_changelog_has_a_dated_section_for_the_version() -> None:
    released = re.findall(
        r"^## (\d+\.\d+\.\d+) - (\d{4}-\d{2}-\d{2})$", text_of(ROOT / "CHANGELOG.md"), flags=re.MULTILINE
    )

    assert released[0][0] == VERSION


def test_citation_is_of_the_version_and_its_date() -> None:
    citation, changelog = text_of(ROOT / "CITATION.cff"), text_of(ROOT / "CHANGELOG.md")

    [date] = re.findall(rf"^## {re.escape(VERSION)} - (.*)$", changelog, flags=re.MULTILINE)
    assert f"version: {VERSION}\n" in citation
    assert f"date-released: {date}\n" in citation
