"""The documentation's pages, and what stands in them."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
GENERATED = {DOCS / "reference" / name for name in ("cli.md", "scenario-keys.md", "experiment-keys.md")}


def name_of(page: Path) -> str:
    """Return a page's path within the repository."""
    return page.relative_to(ROOT).as_posix()


def text_of(page: Path) -> str:
    """Return a page's text."""
    return page.read_text(encoding="utf-8")


def blocks(page: Path, language: str) -> list[str]:
    """Return the fenced blocks of a language, in order."""
    return re.findall(rf"```{language}\n(.*?)```", text_of(page), flags=re.DOTALL)


def lines_to_run(page: Path) -> list[str]:
    """Return the commands that a reader is to type as they stand: indented and with ``.venv/bin``."""
    return re.findall(r"^    \.venv/bin/(passafe .*)$", text_of(page), flags=re.MULTILINE)


def commands_named(page: Path) -> list[str]:
    """Return every command of ``passafe`` that a page shows, also within sentences."""
    text = text_of(page)
    found = lines_to_run(page)
    found += re.findall(r"^    (passafe .*)$", text, flags=re.MULTILINE)
    found += re.findall(r"- run: (passafe [^>\n]*)", text)
    found += re.findall(r"`(passafe [a-z]+ [^`]*)`", text)
    return [re.sub(r"\s+", " ", command).strip() for command in found if "…" not in command and "[" not in command]
