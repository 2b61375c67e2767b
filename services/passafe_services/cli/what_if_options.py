"""Reads the changes of a what-if as a user types them."""

import json
import tomllib
from collections.abc import Mapping, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Any, Final, NamedTuple

from passafe_services.cli.errors import OptionError
from passafe_services.cli.link_text import LINK_KEYS
from passafe_services.cli.options import link_overrides, put_once
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.schema import Scenario
from passafe_services.suggestion import suggestion

RECORDED: Final = "recorded"
HUMAN: Final = "human"
SCENARIO: Final = "scenario"
OPERATORS: Final = f"{RECORDED}, {HUMAN}, {SCENARIO}, a CSV file, or a source such as {{kind='constant', value=[1, 0]}}"

_ALIASES: Final = {"barriers.": "filter.barriers."}
"""Beginnings of keys that may be left shorter."""


class Interval(NamedTuple):
    """Values of a key between which to search.

    Attributes:
        key: The key as typed.
        field: Its dotted name in a scenario.
        low: Lower end.
        high: Upper end.
    """

    key: str
    field: str
    low: float
    high: float


def overrides_of(
    settings: Sequence[str], links: Sequence[str], *, mode: str | None, law: str | None, operator: str
) -> dict[str, Any]:
    """Return the values of a scenario that the options set, by dotted name.

    Raises:
        OptionError: A text of another form, or a key that two of them set.
    """
    found: dict[str, Any] = {}
    for text in settings:
        key, equals, value = text.partition("=")
        if not equals or not key.strip():
            raise OptionError("--set", repr(text), "KEY=VALUE, such as filter.k_i=5 or plant.parameters.sigma=2")
        put_once(found, {field_of(key.strip(), "--set"): _value(value.strip())}, "--set")
    for text in links:
        put_once(found, link_overrides(text), "--link")
    for option, choice in (("mode", mode), ("law", law)):
        if choice is not None:
            put_once(found, {f"filter.{option}": choice}, f"--{option}")
    put_once(found, _source(operator), "--operator")
    return found


def changed_scenario(logged: Scenario, file: str | None, overrides: Mapping[str, Any]) -> Scenario:
    """Return the scenario of a re-run.

    Args:
        logged: Scenario of the log.
        file: Scenario to take instead; ``None``: the log's.
        overrides: Values to put in place of its own, by dotted name.

    Raises:
        ScenarioError: A field that holds what it may not.
    """
    if file is not None:
        return load_scenario(file, overrides)
    return scenario_from(json.loads(logged.model_dump_json()), logged.name, overrides)


def interval_of(text: str) -> Interval:
    """Return the interval that ``KEY=LOW..HIGH`` means.

    Raises:
        OptionError: A text of another form.
    """
    key, equals, ends = text.partition("=")
    low, dots, high = ends.partition("..")
    try:
        numbers = (float(low), float(high))
    except ValueError:
        numbers = (nan, nan)
    if not equals or not dots or not all(map(isfinite, numbers)):
        allowed = "KEY=LOW..HIGH, such as link.plant-to-filter.delay=0..0.5 or filter.k_i=1..50, both ends finite"
        raise OptionError("--search", repr(text), allowed)
    interval = Interval(key, field_of(key, "--search"), *numbers)
    if not interval.low < interval.high:
        raise OptionError("--search", repr(text), "a lower end below the upper one")
    return interval


def field_of(key: str, option: str) -> str:
    """Return the dotted name in a scenario of a key as typed: ``link.NAME.delay`` is ``links.NAME.delay_s``.

    Args:
        key: The key.
        option: The option that has it, for the message.

    Raises:
        OptionError: A setting that no link has.
    """
    if key.startswith("link."):
        _, name, setting = [*key.split(".", 2), "", ""][:3]
        if setting not in LINK_KEYS:
            near = suggestion(setting, LINK_KEYS)
            raise OptionError(option, repr(key), f"link.NAME.SETTING with one of {', '.join(LINK_KEYS)}{near}")
        return f"links.{name}.{LINK_KEYS[setting]}"
    return next((full + key.removeprefix(short) for short, full in _ALIASES.items() if key.startswith(short)), key)


def _source(operator: str) -> dict[str, Any]:
    """Return what an operator sets in a scenario."""
    if operator in {RECORDED, HUMAN, SCENARIO}:
        return {}
    if operator.startswith("{"):
        return {"operator.source": _value(operator)}
    if operator.endswith(".csv"):
        return {"operator.source": {"kind": "recorded", "path": str(Path(operator).absolute())}}
    raise OptionError("--operator", repr(operator), OPERATORS + suggestion(operator, (RECORDED, HUMAN, SCENARIO)))


def _value(text: str) -> object:
    """Return a value in TOML; text that is none is taken as it is."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
