"""Check that the runs of a study can be built, before any of them begins."""

from collections.abc import Iterator

from pydantic import JsonValue

from passafe_services.operator.sources.scenario_source import source_of
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import CompiledScenario
from passafe_services.tools.experiment.axes import BisectAxis, GridAxis
from passafe_services.tools.experiment.cells import cells_of, run_of
from passafe_services.tools.experiment.load import Study


def check(study: Study) -> None:
    """Build the scenario and design of every variant with every value of every axis, the other axes at their first.

    Values that only fail together end the runs that have them with an error.

    Raises:
        ScenarioError: A value that a scenario may not hold.
        DesignError: A design that cannot be built.
        SourceConfigError: A source of commands that does not fit the robot.
    """
    designed: set[str] = set()
    for scenario in tried_scenarios(study):
        key = CompiledScenario.key_of(scenario)
        if key not in designed:
            designed.add(key)
            robot = robot_of(scenario)
            design_of(scenario, robot)
            source_of(scenario)


def tried_scenarios(study: Study) -> Iterator[Scenario]:
    """Yield the scenario of every variant with every value of every axis, the other axes at their first.

    Raises:
        ScenarioError: A value that a scenario may not hold.
    """
    for variant in study.experiment.variants:
        for values in _one_by_one(study):
            yield study.scenario_with(study.experiment.overrides_of(variant, values))


def _one_by_one(study: Study) -> Iterator[dict[str, JsonValue]]:
    """Yield values of all axes: the first ones, then with each other value of each axis."""
    experiment = study.experiment
    axis = experiment.bisected
    first = run_of(experiment, cells_of(experiment)[0], experiment.seeds.first, None if axis is None else axis.low)
    yield first.values
    for varied in experiment.axes:
        if isinstance(varied, GridAxis):
            yield from (first.values | {varied.name: value} for value in varied.values[1:])
        elif isinstance(varied, BisectAxis):
            yield first.values | {varied.name: varied.high}
