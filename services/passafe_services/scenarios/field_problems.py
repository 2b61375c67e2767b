"""Turns what pydantic refuses into words: every field, what it holds, what is allowed."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from passafe_services.scenarios.fields import LISTED, SINGLE
from passafe_services.suggestion import suggestion

_KIND: Final = "kind"
"""The key that tells the members of every union apart."""

_WORDS: Final = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dict_type": "a table",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "greater_than": "above {gt:g}",
    "greater_than_equal": "at least {ge:g}",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "less_than": "below {lt:g}",
    "less_than_equal": "at most {le:g}",
    "missing": "a value: this key is required",
    "model_type": "a table",
    "string_pattern_mismatch": "text that matches {pattern}",
    "string_too_long": "at most {max_length} characters",
    "string_too_short": "at least {min_length} characters",
    "string_type": "text in quotes",
    "too_long": "a list no longer than {max_length}",
    "too_short": "a list no shorter than {min_length}",
    "tuple_type": "a list",
}
"""What is allowed, by pydantic's type of error; of the others, pydantic's own words are kept."""


LONGEST: Final = 60
"""Characters of a value that are shown, at most."""


@dataclass(frozen=True, kw_only=True)
class FieldProblem:
    """A field that holds what it may not.

    Attributes:
        field: Its dotted name.
        got: What it holds, in words.
        allowed: What it may hold, in words.
    """

    field: str
    got: str
    allowed: str

    def __str__(self) -> str:
        return f"{self.field}: got {self.got}, allowed {self.allowed}"


def problems_text(subject: str, problems: Sequence[FieldProblem]) -> str:
    """Return a line for one problem; for several, a line for each below one that counts them."""
    if len(problems) == 1:
        return f"{subject}: {problems[0]}"
    return "\n  ".join([f"{subject}: {len(problems)} errors", *map(str, problems)])


def problems_of(error: ValidationError, model: type[BaseModel]) -> tuple[FieldProblem, ...]:
    """Return every field that pydantic refused, in the order of the model.

    Args:
        error: What it raised.
        model: The model that it was to fill.
    """
    found = error.errors()
    inner = {details["loc"][:length] for details in found for length in range(len(details["loc"]))}
    # A list whose entries are refused counts as too short, too: its entries say what is wrong.
    return tuple(
        _problem(details, model) for details in found if details["type"] != "too_short" or details["loc"] not in inner
    )


def shown(value: object) -> str:
    """Return a value as files write it, in one line, shortened to 60 characters."""
    text = " ".join(_written(value).split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1].rstrip()}…"


def _written(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return f"[{', '.join(map(_written, value))}]"
    return repr(value)


def _problem(details: ErrorDetails, model: type[BaseModel]) -> FieldProblem:
    kind, context = details["type"], details.get("ctx", {})
    *outer, last = details["loc"] or ("",)
    if kind == "extra_forbidden":
        path, place = _followed(model, outer)
        return _unknown_key([*path, str(last)], list(_models(place)[0].model_fields))
    if kind == "literal_error" and last == "[key]":
        path, _ = _followed(model, outer)
        return _unknown_key(path, _quoted(context["expected"]))
    path, place = _followed(model, details["loc"])
    got, allowed = shown(details["input"]), _allowed(details)
    if kind == "missing":
        got = "nothing"
    elif kind == "literal_error":
        allowed += suggestion(str(details["input"]), _quoted(context["expected"]))
    elif kind in {"union_tag_invalid", "union_tag_not_found"}:
        tags = [tag for member in _models(place) for tag in _tags(member)]
        tag = context.get("tag")
        got = "nothing" if tag is None else repr(tag)
        path, allowed = [*path, _KIND], ", ".join(tags) + suggestion(str(tag), tags)
    elif kind == "value_error":  # our own message names the field and what it holds
        reported, separator, own = allowed.partition(", allowed ")
        if separator:
            inner, _, got = reported.rpartition("got ")
            path, allowed = [*path, *filter(None, [inner.rstrip(": ")])], own
    return FieldProblem(field=".".join(path) or "file", got=got, allowed=allowed)


def _unknown_key(path: Sequence[str], keys: Sequence[str]) -> FieldProblem:
    allowed = ", ".join(keys) + suggestion(path[-1], keys)
    return FieldProblem(field=".".join(path), got="an unknown key", allowed=allowed)


def _allowed(details: ErrorDetails) -> str:
    if details["type"] in _WORDS:
        return _WORDS[details["type"]].format_map(details.get("ctx", {}))
    return details["msg"].removeprefix("Input should be ").removeprefix("Value error, ")


def _quoted(expected: str) -> list[str]:
    return re.findall(r"'([^']*)'", expected)


def _followed(model: type[BaseModel], location: Sequence[int | str]) -> tuple[list[str], Any]:
    """Return the names on the way to a place as a file has them, and the type that the place has."""
    path: list[str] = []
    place: Any = model
    for part in location:
        members = _models(place)
        if part in {SINGLE, LISTED} and not any(part in member.model_fields for member in members):
            continue
        of_kind = [member for member in members if part in _tags(member)]
        if len(members) > 1 and of_kind:  # pydantic names the member of a union; a file does not
            [place] = of_kind
            continue
        path.append(str(part))
        place = _inside(place, part)
    return path, place


def _inside(place: Any, part: int | str) -> Any:  # noqa: ANN401 - annotations are of any type
    """Return the type of an entry of a table or list."""
    for member in _members(place):
        if isinstance(member, type) and issubclass(member, BaseModel) and part in member.model_fields:
            return member.model_fields[str(part)].annotation
        arguments = get_args(member)
        if arguments and get_origin(member) is tuple and isinstance(part, int):
            return arguments[0]
        if arguments and get_origin(member) is dict:
            return arguments[1]
    return None


def _members(place: Any) -> list[Any]:  # noqa: ANN401 - annotations are of any type
    """Return the types that an annotation allows."""
    if get_origin(place) is Annotated:
        return _members(get_args(place)[0])
    if get_origin(place) in {Union, UnionType}:
        return [member for argument in get_args(place) for member in _members(argument)]
    return [place]


def _models(place: Any) -> list[type[BaseModel]]:  # noqa: ANN401 - annotations are of any type
    return [member for member in _members(place) if isinstance(member, type) and issubclass(member, BaseModel)]


def _tags(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the kinds that a member of a union stands for."""
    field = model.model_fields.get(_KIND)
    return get_args(field.annotation) if field is not None and get_origin(field.annotation) is Literal else ()
