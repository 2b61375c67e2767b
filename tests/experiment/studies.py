"""Small studies for tests: a few tens of milliseconds of plant time."""

from collections.abc import Mapping

from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.experiment.load import Study, experiment_from

NAME = "notomista-cai-2020"
BOTH_WAYS = ["links.plant-to-filter.delay_s", "links.filter-to-plant.delay_s"]
DELAY = {"name": "delay_s", "keys": BOTH_WAYS, "values": [0.0, 0.01]}


def study(
    scenario: str = NAME, duration_s: float = 0.1, *, overrides: Mapping[str, object] | None = None, **fields: object
) -> Study:
    content = {"schema_version": 2, "name": "small", "title": "Small", "scenario": scenario}
    fields["overrides"] = {"duration_s": duration_s, **(overrides or {})}
    return Study(
        experiment=experiment_from(content | fields, "small.toml"),
        scenario=load_scenario(scenario).model_dump(mode="json", exclude_unset=True),
    )
