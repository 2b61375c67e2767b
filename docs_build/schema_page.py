"""Reference of a TOML file's keys, generated from the pydantic model that reads it."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from inspect import getdoc
from typing import Any, Final, TypeAlias

from markdown.extensions.toc import slugify  # type: ignore[import-untyped]  # Markdown ships no types
from pydantic import BaseModel

JsonSchema: TypeAlias = Mapping[str, Any]

_NAMES: Final = {"number": "number", "integer": "integer", "string": "text", "boolean": "true or false"}
_LIMITS: Final = {"minimum": "from", "exclusiveMinimum": "above", "maximum": "to", "exclusiveMaximum": "below"}


class SchemaPage:
    """Renders one model: a section per table of the file, in the order in which the file names them."""

    def __init__(self, model: type[BaseModel], base: type[BaseModel]) -> None:
        """Read the model's schema.

        Args:
            model: The model of the whole file.
            base: Base class of all its parts, whose docstrings are looked up by name.
        """
        self._root = model.model_json_schema()
        definitions: Mapping[str, JsonSchema] = self._root.get("$defs", {})
        self._definitions = {name: one for name, one in definitions.items() if "properties" in one}
        self._classes = {one.__name__: one for one in (model, *_descendants(base))}
        self._headings: dict[str, str] = {}
        self._add_headings(self._root)

    def render(self) -> str:
        """Return the sections."""
        sections = [self._section("Top level", self._root["title"], self._root)]
        sections += [self._section(heading, name, self._definitions[name]) for name, heading in self._headings.items()]
        return "\n\n".join(sections) + "\n"

    def _add_headings(self, schema: JsonSchema, path: str = "") -> None:
        """Give every definition that a schema leads to a heading: the path of its first use, and its kind."""
        for key, field in schema.get("properties", {}).items():
            for name in _references(field):
                if name in self._headings or name not in self._definitions:
                    continue
                definition = self._definitions[name]
                where = f"{path}.{key}".lstrip(".")
                kinds = _kinds(definition)
                self._headings[name] = f"{where}: {kinds}" if kinds else where
                self._add_headings(definition, where)

    def _section(self, heading: str, name: str, schema: JsonSchema) -> str:
        summary, _ = _docstring(schema.get("description", ""))
        meanings: dict[str, str] = {}
        for ancestor in reversed(self._classes[name].__mro__):
            meanings |= _docstring(getdoc(ancestor) or "")[1]
        required = schema.get("required", ())
        rows = [
            (
                f"`{key}`",
                self._type(field),
                "required" if key in required else _default(field),
                meanings.get(key, ""),
            )
            for key, field in schema.get("properties", {}).items()
        ]
        return f"## {heading}\n\n{summary}\n\n" + _table(("Key", "Allowed", "Default", "Meaning"), rows)

    def _type(self, field: JsonSchema) -> str:
        alternatives = field.get("anyOf") or field.get("oneOf")
        if alternatives:
            return " or ".join(self._type(one) for one in alternatives if one.get("type") != "null")
        if "$ref" in field:
            return self._link(field["$ref"])
        choices = [field["const"]] if "const" in field else field.get("enum")
        if choices:
            return ", ".join(f"`{value}`" for value in choices)
        special = {"array": self._array, "object": self._object}.get(field.get("type", ""))
        return special(field) if special else f"{_NAMES.get(field.get('type', ''), 'any value')}{_range(field)}"

    def _array(self, field: JsonSchema) -> str:
        least, most = field.get("minItems"), field.get("maxItems")
        if "prefixItems" in field:
            return f"list of {len(field['prefixItems'])}: " + ", ".join(self._type(one) for one in field["prefixItems"])
        number = "" if least is None and most is None else f" of {_span(least, most)}"
        return f"list{number}: {self._type(field.get('items', {}))}"

    def _object(self, field: JsonSchema) -> str:
        values = field.get("additionalProperties", {})
        names = field.get("propertyNames", {}).get("enum")
        keys = f" with keys {', '.join(f'`{name}`' for name in names)}" if names else ""
        return f"table{keys}: {self._type(values if isinstance(values, Mapping) else {})}"

    def _link(self, reference: str) -> str:
        name = reference.rpartition("/")[2]
        heading = self._headings.get(name)
        if heading is None:
            return "any value"
        return f"[{_kinds(self._definitions[name]) or heading}](#{slugify(heading, '-')})"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table; pipes and line breaks within cells are escaped."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(" ".join(c.split()).replace("|", "\\|") for c in line) + " |" for line in lines)


def _inline(text: str) -> str:
    """Return a docstring's text on one line, with Markdown's code marks."""
    return " ".join(text.replace("``", "`").split())


def _descendants(base: type[BaseModel]) -> Iterator[type[BaseModel]]:
    for child in base.__subclasses__():
        yield child
        yield from _descendants(child)


def _references(field: Any) -> Iterator[str]:  # noqa: ANN401 - JSON holds anything
    if isinstance(field, Mapping):
        if "$ref" in field:
            yield field["$ref"].rpartition("/")[2]
        for key, value in field.items():
            if key != "discriminator":
                yield from _references(value)
    elif isinstance(field, Sequence) and not isinstance(field, str):
        for value in field:
            yield from _references(value)


def _kinds(definition: JsonSchema) -> str:
    kind = definition.get("properties", {}).get("kind", {})
    return str(kind.get("const", "")) or ", ".join(kind.get("enum", ()))


def _docstring(text: str) -> tuple[str, dict[str, str]]:
    """Return a docstring's prose, and the meanings of its ``Attributes`` section by name."""
    prose, _, attributes = text.partition("\n\nAttributes:\n")
    meanings = {
        name: _inline(meaning)
        for name, meaning in re.findall(r"^ {4}(\w+): (.*(?:\n {5,}.*)*)", attributes, re.MULTILINE)
    }
    return "\n\n".join(_inline(paragraph) for paragraph in prose.split("\n\n")), meanings


def _default(field: JsonSchema) -> str:
    if "default" not in field or field["default"] is None or isinstance(field["default"], Mapping):
        return ""
    value = field["default"]
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return "" if value in ("", []) else f"`{_number(value)}`" if isinstance(value, float) else f"`{value}`"


def _range(field: JsonSchema) -> str:
    limits = [f" {word} {_number(field[key])}" for key, word in _LIMITS.items() if key in field]
    pattern = f" like `{field['pattern']}`" if "pattern" in field else ""
    length = _span(field.get("minLength"), field.get("maxLength"))
    return "".join(limits) + pattern + (f" of {length} characters" if length else "")


def _number(value: float) -> str:
    return f"{value:.6g}".replace("e+0", "e").replace("e+", "e")


def _span(least: int | None, most: int | None) -> str:
    if least is None and most is None:
        return ""
    if least == most:
        return str(least)
    return f"{least or 0} or more" if most is None else f"{least or 0} to {most}"
