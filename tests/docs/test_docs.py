"""What the documentation shows works."""

import re
import shlex
import subprocess
import sys
import tomllib
from math import degrees
from pathlib import Path
from typing import get_args

import pytest
from passafe_protocol.topics import LINKS
from passafe_services.cli.link_text import LINK_KEYS
from passafe_services.operator.sources.scenario_source import crossover_loop
from passafe_services.scenarios.barrier_kinds.motion import Motion
from passafe_services.scenarios.barrier_kinds.registry import SHIPPED, kind_words
from passafe_services.scenarios.link_schema import ScenarioLink
from passafe_services.scenarios.load import load_scenario, scenario_from
from passafe_services.scenarios.robot_models import ROBOT_MODELS
from passafe_services.scenarios.source_schema import AdversarySource, HumanSource, Source
from passafe_services.simulation import lockstep_loop
from passafe_services.tools.experiment.check import check
from passafe_services.tools.experiment.load import Study, experiment_from
from passafe_services.tools.experiment.plan import Plan
from passafe_services.tools.experiment.runner import StudyRunner

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL)


def kinds_of(union: object) -> set[str]:
    """Words that a discriminated union of the schema knows."""
    members = get_args(get_args(union)[0])
    return {kind for member in members for kind in get_args(member.model_fields["kind"].annotation)}


def commands() -> list[str]:
    found = []
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        found += re.findall(r"^    \.venv/bin/(passafe .*)$", text, flags=re.MULTILINE)
        found += re.findall(r"`(passafe [a-z]+ [^`]*)`", text)
    return sorted({re.sub(r"\s+", " ", command) for command in found if "…" not in command})


def test_the_readmes_python_runs_as_it_stands() -> None:
    [program] = blocks(ROOT / "README.md", "python")

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("MODIFIED")


@pytest.mark.parametrize(("number", "name"), [(0, "two-walls"), (1, "every-kind")])
def test_the_example_scenarios_run_as_they_stand(number: int, name: str) -> None:
    text = blocks(ROOT / "docs" / "scenarios.md", "toml")[number]
    scenario = scenario_from(tomllib.loads(text), "docs/scenarios.md")

    loop = lockstep_loop(scenario)
    loop.run(300)

    assert scenario.name == name


def test_every_kind_of_barrier_motion_and_robot_is_in_the_examples_or_tables() -> None:
    page = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    example = tomllib.loads(blocks(ROOT / "docs" / "scenarios.md", "toml")[1])
    kinds = {barrier["kind"] for barrier in example["filter"]["barriers"]}
    motions = {barrier["motion"]["kind"] for barrier in example["filter"]["barriers"] if "motion" in barrier}

    assert kinds == {word for kind in SHIPPED for word in kind_words(kind)}
    assert motions == kinds_of(Motion)
    for word in (*kinds, *motions, *ROBOT_MODELS):
        assert f"| `{word}` |" in page or f"`{word}` (" in page, word


def test_every_source_of_commands_and_every_parameter_of_the_person_is_in_the_tables() -> None:
    scenarios = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    operators = (ROOT / "docs" / "operators.md").read_text(encoding="utf-8")

    for kind in kinds_of(Source):
        assert f"| `{kind}` |" in scenarios, kind
    for name, field in HumanSource.model_fields.items():
        if name not in ("kind", "targets"):
            assert f"| `{name}` | {field.default:g} |" in operators, name
    for strategy in get_args(AdversarySource.model_fields["strategy"].annotation):
        assert f"| `{strategy}` |" in operators, strategy


def test_the_margins_on_the_page_of_operators_are_the_model_s() -> None:
    text = (ROOT / "docs" / "operators.md").read_text(encoding="utf-8")
    for omega, said in ((2.0, "it is {} s ({}°)"), (1.5, "for ω_c = 1.5 {} s ({}°)"), (3.0, "for ω_c = 3\n{} s ({}°)")):
        config = {"kind": "human", "targets": [{"at_s": 0, "position": [0]}], "crossover_rad_per_s": omega}
        loop = crossover_loop(HumanSource.model_validate(config))
        assert said.format(f"{loop.delay_margin_s:.2f}", f"{degrees(loop.phase_margin_rad):.0f}") in text


def test_the_barrier_of_one_s_own_decides_as_it_stands() -> None:
    [program] = blocks(ROOT / "docs" / "scenarios.md", "python")

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)

    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("1 MODIFIED")


def test_the_page_of_links_names_every_setting_and_its_planned_changes_can_be_planned() -> None:
    page = ROOT / "docs" / "links.md"
    text = page.read_text(encoding="utf-8")
    changes = tomllib.loads(blocks(page, "toml")[0])["link_changes"]

    for field in ScenarioLink.model_fields:
        assert f"`{field}`" in text, field
    for key in LINK_KEYS:
        assert f"`{key}" in text or key.startswith("burst-"), key
    for link in LINKS:
        assert f"`{link}`" in text
    assert len(load_scenario("notomista-cai-2020", {"link_changes": changes}).link_changes) == 1


def test_the_example_experiment_and_its_bisected_axis_can_be_run() -> None:
    whole, axis = (tomllib.loads(text) for text in blocks(ROOT / "docs" / "experiments.md", "toml"))
    scenario = load_scenario(whole["scenario"]).model_dump(mode="json", exclude_unset=True)
    whole["overrides"]["duration_s"] = 0.05
    for content in (whole, whole | axis):
        study = Study(experiment=experiment_from(content, "docs/experiments.md"), scenario=scenario)
        check(study)
        result = StudyRunner(study).result(next(Plan(study.experiment).first()))
        assert result.figures is not None, result.error

    kinds = {axis["kind"] for axis in (*whole["axes"], *axis["axes"]) if "kind" in axis}
    assert kinds == {"uniform", "bisect"}


@pytest.mark.parametrize("command", commands())
def test_every_command_that_is_shown_has_the_options_that_are_shown(command: str) -> None:
    words = shlex.split(command)[1:]

    done = subprocess.run(
        [sys.executable, "-P", "-m", "passafe_services.cli", *words, "--help"],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )

    assert done.returncode == 0, done.stderr


def test_links_between_pages_lead_somewhere() -> None:
    for page in PAGES:
        for target in re.findall(r"\]\(([^)#:]+)\)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
