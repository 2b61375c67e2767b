"""Rewrites the records in a copy of the sources as plain classes: those mypyc makes C structs of, msgspec's it cannot.

``python native_records.py FILE …`` rewrites the files in place. A record is a class whose first base is ``Struct``, or
``Record``, the base of all messages. It is made, compared, hashed and printed as before, and tells its annotations;
what it no longer does is refuse changes, which mypy has seen to by then.
"""

import ast
import sys
from dataclasses import dataclass
from pathlib import Path

BASES = ("Struct", "Record")

PRINTED = """
def __repr__(self) -> str:
    shown = [f"{name}={getattr(self, name)!r}" for name in type(self).__annotations__]
    return f"{type(self).__name__}({', '.join(shown)})"
"""

COMPARED = """
def __eq__(self, other: object) -> bool:
    fields = type(self).__annotations__
    return type(self) is type(other) and all([getattr(self, name) == getattr(other, name) for name in fields])

def __hash__(self) -> int:
    return hash(tuple([getattr(self, name) for name in type(self).__annotations__]))
"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Field:
    """A field of a record, as source text.

    Attributes:
        name: Its name.
        annotation: Its type.
        default: Its default, empty if it has none.
    """

    name: str
    annotation: str
    default: str

    @property
    def parameter(self) -> str:
        """The field as a parameter of ``__init__``."""
        return f"{self.name}: {self.annotation}" + (f" = {self.default}" if self.default else "")


def native(source: str) -> str:
    """Return a module's source with its records as plain classes, and everything else as it was."""
    records = [node for node in ast.parse(source).body if isinstance(node, ast.ClassDef) and _is_record(node)]
    lines = source.splitlines()
    for record in reversed(records):
        lines[record.lineno - 1 : record.end_lineno] = map(ast.unparse, _plain_class(record))
    if records:
        lines.insert(lines.index("from msgspec import Struct"), "from mypy_extensions import mypyc_attr")
    return "\n".join(lines) + "\n"


def _is_record(node: ast.ClassDef) -> bool:
    return bool(node.bases) and isinstance(node.bases[0], ast.Name) and node.bases[0].id in BASES


def _plain_class(record: ast.ClassDef) -> list[ast.stmt]:
    """Return the class and what tells its annotations, which a compiled class does not."""
    options = {keyword.arg: ast.unparse(keyword.value) for keyword in record.keywords}
    base = ast.unparse(record.bases[0])
    fields = [_field(line) for line in record.body if _is_field(line)]
    # What msgspec's garbage collector need not look at, Python's need not either.
    attributes = ["acyclic=True"] if base == "Record" or options.get("gc") == "False" else []
    if fields:
        attributes.append("free_list_len=1")
        head = 1 if ast.get_docstring(record) else 0
        rest = [line for line in record.body[head:] if not _is_field(line)]
        record.body = [*record.body[:head], *_maker(fields, options.get("kw_only") == "True"), *rest]
    if base == "Struct":  # messages have what follows from their base
        record.body += ast.parse(PRINTED + ("" if options.get("eq") == "False" else COMPARED)).body
    record.keywords = []
    record.bases = record.bases if base == "Record" else []
    decorator = ast.parse(f"mypyc_attr({', '.join(attributes)})", mode="eval").body
    record.decorator_list = [decorator] if attributes else []
    annotations = {field.name: field.annotation for field in fields}
    ast.fix_missing_locations(record)
    return [record, *ast.parse(f"setattr({record.name}, '__annotations__', {annotations!r})").body]


def _is_field(line: ast.stmt) -> bool:
    return isinstance(line, ast.AnnAssign) and not ast.unparse(line.annotation).startswith("ClassVar")


def _field(line: ast.stmt) -> Field:
    match line:
        case ast.AnnAssign(target=ast.Name(id=name), annotation=annotation, value=value):
            return Field(
                name=name, annotation=ast.unparse(annotation), default="" if value is None else ast.unparse(value)
            )
    raise ValueError(f"field of a record: got {ast.unparse(line)!r}, allowed NAME: TYPE or NAME: TYPE = DEFAULT")


def _maker(fields: list[Field], only_named: bool) -> list[ast.stmt]:
    """Return ``__init__``, as msgspec has it."""
    parameters = ", ".join(field.parameter for field in fields)
    lines = [f"def __init__(self, {'*, ' if only_named else ''}{parameters}) -> None:"]
    return ast.parse("\n".join([*lines, *(f"    self.{field.name} = {field.name}" for field in fields)])).body


def main() -> None:
    """Rewrite the files that are named."""
    for path in map(Path, sys.argv[1:]):
        path.write_text(native(path.read_text()))


if __name__ == "__main__":
    main()
