"""Options that several commands take, and the values that their text stands for."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Final

import typer
from passafe_protocol.topics import LINKS

from passafe_services.cli.errors import OptionError
from passafe_services.cli.link_text import LINK_KEYS, link_fields
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario

DEFAULT_SCENARIO: Final = "notomista-cai-2020"

ScenarioOption = Annotated[
    str,
    typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Shipped scenario (`passafe scenarios`) or TOML file."),
]
RunScenarioOption = Annotated[
    str,
    typer.Option(
        "--scenario",
        "-s",
        metavar="NAME|FILE",
        envvar="PASSAFE_SCENARIO",
        help="Shipped scenario (`passafe scenarios`) or TOML file.",
    ),
]
ModeOption = Annotated[
    str | None,
    typer.Option("--mode", "-m", metavar="MODE", help="What the filter enforces: off, safe, passive or both."),
]
LawOption = Annotated[
    str | None,
    typer.Option("--law", metavar="LAW", help="Rows of the filter: sampled, or continuous as in the paper."),
]
DurationOption = Annotated[
    float | None,
    typer.Option("--duration", "-d", metavar="SECONDS", help="Plant time to run."),
]
RateOption = Annotated[
    float | None,
    typer.Option("--rate", metavar="HZ", help="Ticks per second, instead of the scenario's."),
]
LinkOption = Annotated[
    list[str] | None,
    typer.Option(
        "--link",
        metavar="NAME:KEY=VALUE,…",
        help=f"Impair a link; repeat for others. Names: {', '.join(LINKS)}. Keys: {', '.join(LINK_KEYS)}; times in "
        "seconds, probabilities from 0 to 1.",
    ),
]
RotateMbOption = Annotated[
    float | None,
    typer.Option("--rotate-mb", metavar="MB", min=0.1, help="Recorder: begin another file of the log at this size."),
]
RotateSOption = Annotated[
    float | None,
    typer.Option(
        "--rotate-s", metavar="SECONDS", min=1.0, help="Recorder: begin another file of the log after this time."
    ),
]
DEFAULT_ROTATE_S: Final = 3600.0
"""Time after which a file of the log ends: the index of one that is written for days would fill the memory."""
WorkersOption = Annotated[
    int, typer.Option("--workers", "-w", metavar="N", min=0, help="Worker processes; 0: one for each processor.")
]


def scenario_from_options(
    name_or_file: str,
    *,
    mode: str | None = None,
    law: str | None = None,
    duration_s: float | None = None,
    rate_hz: float | None = None,
    links: Sequence[str] = (),
    prediction: bool | None = None,
    gatekeeper: bool | None = None,
    robot: str | None = None,
) -> Scenario:
    """Return a scenario with the command line's values in place of its own.

    Raises:
        ScenarioError: A field that holds what it may not.
        OptionError: A link in another form than ``NAME:KEY=VALUE,…``.
        RobotCodeError: A ``robot`` that names no function which returns one.
    """
    given = {
        "filter.mode": mode,
        "filter.law": law,
        "duration_s": duration_s,
        "rate_hz": rate_hz,
        "filter.prediction": prediction,
        "filter.gatekeeper": gatekeeper,
    }
    overrides: dict[str, Any] = {field: value for field, value in given.items() if value is not None}
    for text in links:
        put_once(overrides, link_overrides(text), "--link")
    return load_scenario(name_or_file, overrides, robot)


def writable_folder(path: Path, option: str = "--out") -> Path:
    """Return the folder; create it if it does not exist.

    Args:
        path: The folder.
        option: The option that named it, for the message.

    Raises:
        OptionError: The folder cannot be created or written.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".passafe-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OptionError(option, f"{path} ({error.strerror})", "a writable folder") from error
    return path


def put_once(found: dict[str, Any], more: Mapping[str, Any], option: str) -> None:
    """Put the values of an option beside those of the options before it; none may set again what another has set.

    Args:
        found: Values of a scenario so far, by dotted name.
        more: The option's.
        option: Its name, for the message.

    Raises:
        OptionError: A key that is set already, in whole or in part.
    """
    for key, value in more.items():
        require_unset(found, key, option)
        found[key] = value


def require_unset(found: Mapping[str, Any], key: str, option: str) -> None:
    """Require that no option before has set a key, nor a part of it, nor what it is part of.

    Raises:
        OptionError: One has.
    """
    for other in found:
        if f"{key}.".startswith(f"{other}.") or other.startswith(f"{key}."):
            raise OptionError(option, f"{key} with {other} given already", "each key once, in all options together")


def link_overrides(text: str) -> dict[str, Any]:
    """Return the values of a scenario that one ``NAME:KEY=VALUE,…`` sets, by dotted name.

    Raises:
        OptionError: A text of another form.
    """
    name, separator, settings = text.partition(":")
    if not separator:
        raise OptionError("--link", repr(text), f"NAME:KEY=VALUE,… with {', '.join(LINK_KEYS)}")
    fields = link_fields(settings.split(","), "--link")
    return {f"links.{name}.{field}": value for field, value in fields.items()}
