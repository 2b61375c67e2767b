"""Load the templates and style sheets of page and reports."""

from pathlib import Path
from typing import Final

from jinja2 import Environment, FileSystemLoader, StrictUndefined

STATIC: Final = Path(__file__).parent / "static"
"""Folder of the files that the server serves and the reports include."""

TEMPLATES: Final = Environment(
    loader=FileSystemLoader(Path(__file__).parent / "templates"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def report_css() -> str:
    """Return the style sheet of a report, to be included in it."""
    return (STATIC / "common.css").read_text("utf-8") + (STATIC / "report.css").read_text("utf-8")
