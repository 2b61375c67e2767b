"""One word for one thing: words that have given way to the field's term occur nowhere."""

import re
from pathlib import Path

import pytest
from pages import ROOT

REPLACED = {
    r"armings?|armed|unarmed|disarm(?:s|ed|ing|ings)?": "input sequence, sequenced, sequence break",
    r"lanes?|crowds?": "batch, batch element, adversary batch",
    r"singly": "scalar",
    r"tapes?": "run trace",
    r"kits?|portions?": "compiled study, chunk",
    r"crews?": "worker pool",
    r"dut(?:y|ies)": "constraints",
    r"cushion(?:s|ed)?": "tightening",
    r"poison(?:s|ed|ing)?": "NaN guard",
    r"strayed": "outside the trust region",
    r"gauges?": "barrier distance",
    r"wording": "override text",
    r"announcer": "event emitter",
    r"resteps?|re-?stepped|step(?:s|ped|ping)? again|stepped a second time": "replay",
    r"foresight": "predictor",
    r"pushers?": "adversary operator",
    r"to and fro": "oscillate",
    r"by and by": "linearly, gradually",
    r"go(?:es)? on where|gone on with": "resume",
    r"told|hears?|heard": "reported, received",
    r"figures": "metrics, values; drawn ones are charts",
}
"""Patterns of whole words, parts of identifiers included, and what is said instead."""

ALLOWED: dict[str, tuple[str, str]] = {
    "tests/docs/test_words.py": (r".*", "the table above"),
    "CHANGELOG.md": (r"armings?|singly", "names what was replaced"),
}
"""Files in which a pattern may occur, and the reason."""

CLEAN = (
    "passafe",
    "protocol",
    "services",
    "dashboard",
    "tests",
    "benchmarks",
    "wheel_build",
    "docs",
    "docs_build",
    "deploy",
    "examples",
    ".ci",
    "README.md",
    "CONTRIBUTING.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "Makefile",
    "mkdocs.yml",
    "docker-compose.yml",
    "Dockerfile",
    "pyproject.toml",
)
"""Folders and files that are held to it."""

SUFFIXES = {".py", ".md", ".toml", ".proto", ".html", ".js", ".css", ".cff", ".yml"}


def _files(root: str) -> list[Path]:
    path = ROOT / root
    if path.is_file():
        return [path]
    installed = {"__pycache__", "node_modules"}
    return [one for one in path.rglob("*") if one.suffix in SUFFIXES and installed.isdisjoint(one.parts)]


def _words(text: str) -> str:
    """Return text in which identifiers are taken apart: ``SafeStart`` and ``safe_start`` become words."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_", " ", text)


@pytest.mark.parametrize("root", CLEAN)
def test_replaced_words_do_not_occur(root: str) -> None:
    found = []
    for path in _files(root):
        name = path.relative_to(ROOT).as_posix()
        allowed, _ = ALLOWED.get(name, ("(?!)", ""))
        found += [
            f"{name}:{number}: {hit!r}, say {instead}"
            for number, line in enumerate(_words(path.read_text(encoding="utf-8")).splitlines(), start=1)
            for pattern, instead in REPLACED.items()
            for hit in re.findall(rf"\b(?:{pattern})\b", line, flags=re.IGNORECASE)
            if not re.fullmatch(allowed, hit, flags=re.IGNORECASE)
        ]

    assert not found, "\n".join(found[:40])


def test_allowed_files_exist_and_have_a_reason() -> None:
    for name, (_, reason) in ALLOWED.items():
        assert (ROOT / name).exists()
        assert reason
