"""Reference of the command line, generated from the commands themselves."""

import re
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any, Final

import typer
from markdown_text import table
from passafe_services.cli.app import app

_TYPES: Final = {"str": "text", "float": "number", "int": "integer", "Path": "path", "bool": ""}


def render() -> str:
    """Return a section for each command."""
    return "\n\n".join(_sections("passafe", typer.main.get_command(app))) + "\n"


def _sections(name: str, command: Any) -> Iterator[str]:  # noqa: ANN401 - Typer's own command classes are private
    commands = getattr(command, "commands", None)
    if commands is None:
        yield _section(name, command)
        return
    for child, below in commands.items():
        yield from _sections(f"{name} {child}", below)


def _section(name: str, command: Any) -> str:  # noqa: ANN401 - as above
    arguments = [one for one in command.params if one.param_type_name == "argument"]
    options = [one for one in command.params if one.param_type_name == "option" and not one.hidden]
    usage = " ".join([name, *("[OPTIONS]" for _ in options[:1]), *(_argument(one) for one in arguments)])
    parts = [f"## {name}", _with_lists(command.help or ""), f"```text\n{usage}\n```"]
    if arguments:
        rows = [(f"`{_argument(one)}`", _allowed(one), _sentence(one)) for one in arguments]
        parts.append(table(("Argument", "Allowed", "Meaning"), rows))
    if options:
        rows = [(", ".join(f"`{text}`" for text in one.opts), _allowed(one), _sentence(one)) for one in options]
        parts.append(table(("Option", "Allowed", "Meaning"), rows))
    return "\n\n".join(parts)


def _with_lists(text: str) -> str:
    """Return help text with the empty line before a list that Markdown needs."""
    return re.sub(r"(?<=\n)([^-\n][^\n]*\n)(?=- )", r"\1\n", text)


def _argument(parameter: Any) -> str:  # noqa: ANN401 - as above
    name = parameter.metavar or parameter.name.upper()
    name = name if parameter.nargs == 1 or name.endswith("…") else f"{name}…"
    return name if parameter.required else f"[{name}]"


def _allowed(parameter: Any) -> str:  # noqa: ANN401 - as above
    annotation = parameter.type_descriptor.annotation
    if isinstance(annotation, type) and issubclass(annotation, Enum):
        return ", ".join(f"`{choice.value}`" for choice in annotation)
    if parameter.metavar is not None and parameter.param_type_name == "option":
        return " or ".join(f"`{name}`" for name in parameter.metavar.split("|"))
    least, most = parameter.min, parameter.max
    span = (
        "" if least is None and most is None else f" {least:g} to {most:g}" if most is not None else f" from {least:g}"
    )
    return f"{_TYPES.get(getattr(annotation, '__name__', ''), 'text')}{span}"


def _sentence(parameter: Any) -> str:  # noqa: ANN401 - as above
    default = parameter.default
    if isinstance(default, Enum):
        default = default.value
    text = parameter.help or ""
    if parameter.required and parameter.param_type_name == "option":
        return f"{text} **Required.**"
    if default in (None, False, []) or (isinstance(default, Path) and not str(default)):
        return text
    return f"{text} Default: `{default}`."
