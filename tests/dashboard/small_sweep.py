"""A sweep of two modes and two gains, two seeds each, of a tenth of a second: with real results in a folder."""

import tomllib
from pathlib import Path

from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.experiment.load import Study, experiment_from
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.run_result import RunResult, experiment_results
from passafe_services.tools.experiment.runner import StudyRunner

EXPERIMENT_TOML = """
schema_version = 2
name = "small"
title = "Two modes"
scenario = "notomista-cai-2020"
seeds = { count = 2 }
overrides = { duration_s = 0.1 }

[variants]
off = { "filter.mode" = "off" }
both = { "filter.mode" = "both" }

[[axes]]
name = "delay_s"
keys = ["links.plant-to-filter.delay_s"]
values = [0.0, 0.02]

[criteria]
safe = { metric = "h_min", at_least = 5.0 }
quick = { metric = "u_norm_max", at_most = 7.0 }
"""
"""The experiment as a file."""

EXPERIMENT = tomllib.loads(EXPERIMENT_TOML)


def small_study() -> Study:
    experiment = experiment_from(EXPERIMENT, "small")
    scenario = load_scenario(experiment.scenario).model_dump(mode="json", exclude_unset=True)
    return Study(experiment=experiment, scenario=scenario)


def small_results(study: Study) -> list[RunResult]:
    """Return the results of all runs."""
    runner = StudyRunner(study)
    return [runner.result(run) for run in Plan(study.experiment).first()]


def write_results(folder: Path, study: Study, results: list[RunResult]) -> Path:
    """Add results to those of the sweep in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for _ in experiment_results(folder / "results.jsonl", study).add([results]):
        pass
    return folder
