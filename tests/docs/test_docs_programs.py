"""The programs, scenarios and experiments that pages show work as they stand."""

import subprocess
import sys
import tomllib
from math import degrees
from pathlib import Path
from typing import get_args

import pytest
from pages import DOCS, ROOT, blocks, text_of
from passafe_protocol.topics import LINKS
from passafe_services.cli.link_text import LINK_KEYS
from passafe_services.operator.sources.scenario_source import crossover_loop
from passafe_services.scenarios.barrier_kinds.motion import Motion
from passafe_services.scenarios.barrier_kinds.registry import SHIPPED, kind_words
from passafe_services.scenarios.link_schema import ScenarioLink
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.robot_models import ROBOT_MODELS
from passafe_services.scenarios.robots.shipped import SHIPPED as SHIPPED_ROBOTS
from passafe_services.scenarios.source_schema import AdversarySource, HumanSource, SourceConfig
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.experiment.check import check
from passafe_services.tools.experiment.load import Study, experiment_from
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runner import StudyRunner

OWN_SCENARIO = DOCS / "how-to" / "own-scenario.md"
OWN_EXPERIMENT = DOCS / "how-to" / "own-experiment.md"
OPERATORS = DOCS / "operators.md"


def kinds_of(union: object) -> set[str]:
    """Words that a discriminated union of the schema knows."""
    members = get_args(get_args(union)[0])
    return {kind for member in members for kind in get_args(member.model_fields["kind"].annotation)}


@pytest.mark.parametrize(
    ("page", "begins"), [(ROOT / "README.md", "MODIFIED"), (DOCS / "how-to" / "library.md", "1 MODIFIED")]
)
def test_the_program_of_a_page_runs(page: Path, begins: str) -> None:
    program = "\n".join(blocks(page, "python"))  # each continues the one before

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(begins)


def test_the_program_that_opens_a_log_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    [program] = blocks(DOCS / "how-to" / "open-a-log.md", "python")
    monkeypatch.chdir(tmp_path)
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "simulate", "--duration", "0.5"]
    subprocess.run([*command, "--out", "runs/bad.mcap"], check=True, capture_output=True, timeout=120)

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 0, done.stderr
    assert "barrier_disk_psi_0" in done.stdout


@pytest.mark.parametrize(("number", "name"), [(0, "two-walls"), (1, "every-kind")])
def test_the_example_scenarios_run(number: int, name: str) -> None:
    scenario = scenario_from(tomllib.loads(blocks(OWN_SCENARIO, "toml")[number]), OWN_SCENARIO.name)

    lockstep_loop(scenario).run(300)

    assert scenario.name == name


def test_every_kind_of_barrier_motion_and_robot_is_shown() -> None:
    example = tomllib.loads(blocks(OWN_SCENARIO, "toml")[1])
    kinds = {barrier["kind"] for barrier in example["filter"]["barriers"]}
    motions = {barrier["motion"]["kind"] for barrier in example["filter"]["barriers"] if "motion" in barrier}

    shown = kinds | {"own"}  # of robots that bring barriers, in docs/how-to/own-robot.md
    shown |= {barrier.kind for barrier in load_scenario("arm-over-table").filter.barriers}  # of a body with spheres

    assert shown == {word for kind in SHIPPED for word in kind_words(kind)}
    assert motions == kinds_of(Motion)
    for word in (*shown, *motions, *ROBOT_MODELS, *SHIPPED_ROBOTS):
        assert f"| `{word}` |" in text_of(OWN_SCENARIO) or f"`{word}` (" in text_of(OWN_SCENARIO), word


def test_every_operator_and_its_parameters_are_in_tables() -> None:
    page = text_of(OPERATORS)
    for kind in kinds_of(SourceConfig):
        assert f"| `{kind}` |" in page, kind
    for name, field in HumanSource.model_fields.items():
        if name not in ("kind", "targets"):
            assert f"| `{name}` | {field.default:g} |" in page, name
    for strategy in get_args(AdversarySource.model_fields["strategy"].annotation):
        assert f"| `{strategy}` |" in page, strategy


def test_operators_shown_can_be_put_into_a_scenario() -> None:
    for block in blocks(OPERATORS, "toml"):
        operator = tomllib.loads(block)["operator"]
        assert load_scenario("notomista-cai-2020", {"operator": operator}).operator.source.kind


def test_the_delay_margins_shown_are_the_models() -> None:
    page = " ".join(text_of(OPERATORS).split())
    for omega, shown in ((2.0, "it is {} s ({}°)"), (1.5, "for ω_c = 1.5 {} s ({}°)"), (3.0, "for ω_c = 3 {} s ({}°)")):
        config = {"kind": "human", "targets": [{"at_s": 0, "position": [0]}], "crossover_rad_per_s": omega}
        loop = crossover_loop(HumanSource.model_validate(config))
        assert shown.format(f"{loop.delay_margin_s:.2f}", f"{degrees(loop.phase_margin_rad):.0f}") in page


def test_every_setting_of_links_is_explained() -> None:
    page = text_of(DOCS / "links.md")
    for field in ScenarioLink.model_fields:
        assert f"`{field}`" in page, field
    for key in LINK_KEYS:
        assert f"`{key}" in page, key
    for link in LINKS:
        assert f"`{link}`" in page


def test_planned_link_changes_shown_are_accepted() -> None:
    [block] = blocks(DOCS / "how-to" / "bad-network.md", "toml")

    scenario = load_scenario("notomista-cai-2020", tomllib.loads(block))

    assert len(scenario.link_changes) == 1


def test_the_example_experiments_run() -> None:
    whole, axis = (tomllib.loads(text) for text in blocks(OWN_EXPERIMENT, "toml"))
    [tutorial] = (tomllib.loads(text) for text in blocks(DOCS / "tutorial.md", "toml"))
    for content in (whole, whole | axis, tutorial):
        content["overrides"]["duration_s"] = 0.05
        scenario = load_scenario(content["scenario"]).model_dump(mode="json", exclude_unset=True)
        study = Study(experiment=experiment_from(content, "page"), scenario=scenario)
        check(study)
        result = StudyRunner(study).result(next(Plan(study.experiment).first()))
        assert result.metrics is not None, result.error

    kinds = {axis["kind"] for axis in (*whole["axes"], *axis["axes"]) if "kind" in axis}
    assert kinds == {"uniform", "bisect"}
