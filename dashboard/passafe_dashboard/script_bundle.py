"""Join the scripts of a page into one: a report needs no other file, and a page asks the server once."""

import posixpath
import re
from functools import cache
from graphlib import TopologicalSorter
from typing import Final

from passafe_dashboard.markup import STATIC

IMPORT: Final = re.compile(r'^import \{([^}]*)\} from "(\.{1,2}/[a-z_/]+\.js)";\n', re.MULTILINE)
EXPORT: Final = re.compile(r"^export (?=(?:async )?(?:function|class|const) (\w+))", re.MULTILINE)


@cache
def script_bundle(entry: str) -> str:
    """Return a script with a module and all that it imports, each after those that it imports.

    Every module keeps a scope of its own; what the entry exports is bound at the end.

    Args:
        entry: Path of the module below ``static``.

    Raises:
        CycleError: Modules import each other.
    """
    texts: dict[str, str] = {}
    _read(entry, texts)
    order = TopologicalSorter({path: _imports(path, text) for path, text in texts.items()}).static_order()
    scopes = "".join(_scoped(path, texts[path]) for path in order)
    return f"{scopes}const {_bindings(EXPORT.findall(texts[entry]))} = {_scope(entry)};\n"


def _read(path: str, texts: dict[str, str]) -> None:
    """Add the text of a module and of all that it imports."""
    if path not in texts:
        texts[path] = (STATIC / path).read_text("utf-8")
        for imported in _imports(path, texts[path]):
            _read(imported, texts)


def _imports(path: str, text: str) -> list[str]:
    return [_path_from(path, imported) for _, imported in IMPORT.findall(text)]


def _path_from(importer: str, imported: str) -> str:
    return posixpath.normpath(posixpath.join(posixpath.dirname(importer), imported))


def _scoped(path: str, text: str) -> str:
    """Return a module as a call that returns what it exports."""

    def bound(found: re.Match[str]) -> str:
        names = [name.strip().replace(" as ", ": ") for name in found[1].split(",") if name.strip()]
        return f"const {_bindings(names)} = {_scope(_path_from(path, found[2]))};\n"

    body = EXPORT.sub("", IMPORT.sub(bound, text))
    return f"const {_scope(path)} = (() => {{\n{body}return {_bindings(EXPORT.findall(text))};\n}})();\n"


def _bindings(names: list[str]) -> str:
    return "{ " + ", ".join(names) + " }"


def _scope(path: str) -> str:
    """Return the name of a module's scope."""
    return "module_" + path.removesuffix(".js").replace("/", "_")
