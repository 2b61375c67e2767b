"""Join the scripts of a page into one, so that the page needs no other file."""

import re
from typing import Final

from passafe_dashboard.markup import STATIC

IMPORT: Final = re.compile(r'^import \{[^}]*\} from "\./([a-z_]+\.js)";\n', re.MULTILINE)
EXPORT: Final = re.compile(r"^export (?=(?:async )?function |class |const )", re.MULTILINE)


def script_bundle(entry: str) -> str:
    """Return a module of ``static/report`` with all that it imports, each before those that import it.

    Imports and exports are taken out: names at the top of the modules differ, which a test checks.
    """
    order: dict[str, str] = {}
    _visit(entry, order)
    return "".join(order.values())


def _visit(name: str, order: dict[str, str]) -> None:
    if name in order:
        return
    text = (STATIC / "report" / name).read_text("utf-8")
    for imported in IMPORT.findall(text):
        _visit(imported, order)
    order[name] = EXPORT.sub("", IMPORT.sub("", text))
