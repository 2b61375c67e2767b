"""Finds, reads and checks experiment files, and the scenario that each is about."""

import tomllib
from copy import deepcopy
from importlib.resources import files
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, JsonValue, ValidationError

from passafe_services.scenarios.bounded_file import require_bounded, why_unreadable
from passafe_services.scenarios.field_problems import problems_of
from passafe_services.scenarios.load import load_scenario, scenario_from, shipped_scenarios
from passafe_services.scenarios.robots.robot_source import is_installed
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.experiment.axes import Overrides
from passafe_services.tools.experiment.errors import ExperimentError, UnknownExperimentError, UnreadableExperimentError
from passafe_services.tools.experiment.schema import Experiment

EXAMPLES = files("passafe_services.tools.experiment") / "examples"


class Study(BaseModel):
    """An experiment with the scenario that it is about: all that a worker needs to know.

    Attributes:
        experiment: What is asked.
        scenario: The scenario's values before any override, as plain data.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    experiment: Experiment
    scenario: dict[str, JsonValue]

    def scenario_with(self, overrides: Overrides) -> Scenario:
        """Return the scenario with values in place of its own.

        Raises:
            ScenarioError: A field that holds what it may not.
        """
        return scenario_from(
            deepcopy(self.scenario), f"of experiment {self.experiment.name}", overrides, runs_code=True
        )


def shipped_experiments() -> list[str]:
    """Return the names of the experiments that come with passafe, sorted."""
    return sorted(entry.name.removesuffix(".toml") for entry in EXAMPLES.iterdir() if entry.name.endswith(".toml"))


def load_study(name_or_file: str, robot: str | None = None) -> Study:
    """Return a shipped experiment by name, or one from a TOML file, with its scenario.

    Args:
        name_or_file: For example ``delay`` or ``./mine.toml``.
        robot: ``FILE.py:FUNCTION`` of the user's robot.

    Raises:
        UnknownExperimentError: Neither a shipped name nor a file.
        UnreadableExperimentError: A file that is no TOML.
        ExperimentError: A field that holds what it may not.
        ScenarioError: The scenario that it is about cannot be used.
    """
    path = Path(name_or_file)
    try:
        if name_or_file in shipped_experiments():
            text, folder = (EXAMPLES / f"{name_or_file}.toml").read_text(encoding="utf-8"), Path()
        elif path.is_file():
            require_bounded(path)
            text, folder = path.read_text(encoding="utf-8"), path.parent
        else:
            raise UnknownExperimentError(name_or_file, shipped_experiments())
        data = tomllib.loads(text)
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise UnreadableExperimentError(path, why_unreadable(error)) from error
    experiment = experiment_from(data, name_or_file)
    named = experiment.scenario
    scenario = load_scenario(named if named in shipped_scenarios() else str(folder / named), robot=robot)
    values = scenario.model_dump(mode="json", exclude_unset=True)
    if robot is None and is_installed(scenario.plant.model):
        values["plant"].pop("robot", None)  # made for each cell, whose parameters may differ
    return Study(experiment=experiment, scenario=values)


def experiment_from(data: Any, source: str) -> Experiment:  # noqa: ANN401 - TOML may hold anything; this is the check
    """Return the experiment that parsed TOML describes.

    Args:
        data: What the parser returned.
        source: Name or file, for messages.

    Raises:
        ExperimentError: Fields that hold what they may not; all of them are named.
    """
    if isinstance(data, dict) and data.get("schema_version") == 1:
        raise ExperimentError(source, "schema_version", 1, "2, whose criteria say `metric` instead of `figure`")
    try:
        return Experiment.of_file(data)
    except ValidationError as error:
        first, *more = problems_of(error, Experiment)
        raise ExperimentError(source, first.field, first.got, first.allowed, *more) from error
