"""Finds, reads and validates scenario files; the only place where configuration is loaded."""

import json
import tomllib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from passafe_services.scenarios.bounded_file import require_bounded, why_unreadable
from passafe_services.scenarios.errors import ScenarioError, UnknownScenarioError, UnreadableScenarioError
from passafe_services.scenarios.field_problems import problems_of, shown
from passafe_services.scenarios.links import link_changes, link_settings
from passafe_services.scenarios.robot_models import ROBOT_MODELS
from passafe_services.scenarios.robots.robot_source import installed_robot, robot_of_file
from passafe_services.scenarios.schema import Scenario
from passafe_services.suggestion import suggestion


def shipped_scenarios() -> list[str]:
    """Return the names of the scenarios that come with passafe, sorted."""
    entries = files("passafe_services.scenarios").iterdir()
    return sorted(entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml"))


def load_scenario(name_or_file: str, overrides: Mapping[str, Any] | None = None, robot: str | None = None) -> Scenario:
    """Return a shipped scenario by name, or one from a TOML or JSON file.

    Args:
        name_or_file: For example ``notomista-cai-2020`` or ``./mine.toml``.
        overrides: Values to put in place of the file's, by dotted name: ``{"filter.mode": "off"}``. An entry of a
            list is reached by its number or, where it has one, by its name: ``filter.barriers.disk.radius``.
        robot: ``FILE.py:FUNCTION`` of the user's robot, which takes the place of the scenario's model.

    Raises:
        UnknownScenarioError: Neither a shipped name nor a file.
        UnreadableScenarioError: A file that is no TOML or JSON.
        ScenarioError: A field that holds what it may not.
        RobotCodeError: A function that returns no robot.
    """
    if name_or_file in shipped_scenarios():
        text = (files("passafe_services.scenarios") / f"{name_or_file}.toml").read_text(encoding="utf-8")
        return scenario_from(tomllib.loads(text), name_or_file, overrides, robot, runs_code=True)
    path = Path(name_or_file)
    try:
        if not path.is_file():  # raises where a folder on the way may not be searched
            raise UnknownScenarioError(name_or_file, shipped_scenarios())
        require_bounded(path)
        text = path.read_text(encoding="utf-8")
        data = json.loads(text) if path.suffix == ".json" else tomllib.loads(text)
    except (OSError, ValueError, RecursionError) as error:
        raise UnreadableScenarioError(path, why_unreadable(error)) from error
    return scenario_from(data, str(path), overrides, robot, runs_code=True)


def scenario_from(
    data: Any,  # noqa: ANN401 - JSON or TOML may hold anything; this is the check
    source: str,
    overrides: Mapping[str, Any] | None = None,
    robot: str | None = None,
    *,
    runs_code: bool = False,
) -> Scenario:
    """Return the scenario that parsed TOML or JSON describes.

    Args:
        data: What the parser returned.
        source: Name or file, for messages.
        overrides: As for ``load_scenario``.
        robot: Likewise.
        runs_code: Whether a model that is the name of a shipped robot or of an entry point is made by its function;
            never for data from a log or from the bus, which carry their robots.

    Raises:
        ScenarioError: Fields that hold what they may not; all of them are named.
        LinkTraceError: A recorded trace of a link that cannot be used.
        RobotCodeError: A function that returns no robot.
    """
    if not isinstance(data, dict):
        raise ScenarioError(source, "file", type(data).__name__, "a table of fields")
    for dotted, value in (overrides or {}).items():
        _put(data, source, dotted, value)
    if runs_code:
        _put_robot(data, source, robot)
    try:
        scenario = Scenario.of_file(data)
    except ValidationError as error:
        first, *more = problems_of(error, Scenario)
        raise ScenarioError(source, first.field, first.got, first.allowed, *more) from error
    link_settings(scenario)  # a trace that cannot be read is reported now, not when the processes start
    link_changes(scenario)
    return scenario


def _put_robot(data: dict[str, Any], source: str, file: str | None) -> None:
    """Put the robot of a user's file or of an entry point into a scenario's data, where there is one."""
    plant = data.get("plant")
    if not isinstance(plant, dict):
        return  # refused by the schema
    model, parameters = plant.get("model"), plant.get("parameters", {})
    if not isinstance(parameters, dict):
        return
    for name, value in parameters.items():
        if not isinstance(value, int | float):  # a function is called with numbers alone
            raise ScenarioError(source, f"plant.parameters.{name}", shown(value), "a number")
    if file is not None:
        plant["robot"] = robot_of_file(file, parameters).model_dump(mode="json")
    elif plant.get("robot") is None and isinstance(model, str) and model not in ROBOT_MODELS:
        found = installed_robot(model, parameters)
        if found is not None:
            plant["robot"] = found.model_dump(mode="json")


def _put(data: dict[str, Any], source: str, dotted: str, value: object) -> None:
    *path, last = dotted.split(".")
    place: Any = data
    for part in path:
        place = place.setdefault(part, {}) if isinstance(place, dict) else place[_index(place, part, source, dotted)]
    if isinstance(place, dict):
        place[last] = value
    else:
        place[_index(place, last, source, dotted)] = value


def _index(place: object, part: str, source: str, dotted: str) -> int:
    """Return the index of the entry of a list that a part of a dotted name means."""
    if not isinstance(place, list):
        raise ScenarioError(source, dotted, f"{part!r} of {shown(place)}", "a name that leads through tables and lists")
    names = [entry.get("name") if isinstance(entry, dict) else None for entry in place]
    if part in names:
        return names.index(part)
    if part.isdecimal() and int(part) < len(place):
        return int(part)
    allowed = [*filter(None, names), *map(str, range(len(place)))]
    listed = ", ".join(allowed) or "nothing: the list is empty"
    raise ScenarioError(source, dotted, repr(part), listed + suggestion(part, allowed))
