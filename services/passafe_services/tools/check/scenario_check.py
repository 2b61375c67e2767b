"""All that is checked of a scenario, and what of it costs no decision and is therefore checked at every load."""

from collections.abc import Iterator
from typing import Final

from passafe.barrier_chain import derive_chains
from passafe.checks.design_check import formula_findings
from passafe.checks.row_share import StateBox, row_findings
from passafe.errors import DesignError
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity
from passafe.numerics.workspace import interpreted
from passafe_services.loop.machine_code import machine_code
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.check.assumption import assumption_findings
from passafe_services.tools.check.decision_time import decision_time_finding
from passafe_services.tools.check.errors import UnusableScenarioError
from passafe_services.tools.check.fail_safe import fail_safe_findings

WIDTH: Final = 3.0
"""Half width of the box of states where the scenario gives none, in each state's own units."""


def load_findings(scenario: Scenario) -> tuple[Finding, ...]:
    """Return what the formulas of a scenario show, without a decision.

    Raises:
        ScenarioError: The parameters or x0 do not fit the model.
        DesignError: A design that cannot be made.
    """
    robot = robot_of(scenario)
    design = design_of(scenario, robot)
    chains = [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)]
    return (
        *formula_findings(design, chains, scenario.plant.x0),
        *fail_safe_findings(scenario, robot, design),
        *_play_out(scenario),
        *assumption_findings(scenario, robot),
    )


def load_warnings(scenario: Scenario) -> tuple[Finding, ...]:
    """Return the warnings of a scenario that is about to be run.

    Raises:
        UnusableScenarioError: It cannot be used.
    """
    findings = load_findings(scenario)
    for finding in findings:
        if finding.severity is Severity.REFUSED:
            raise UnusableScenarioError(scenario.name, finding)
    return tuple(finding for finding in findings if finding.severity is Severity.WARNING)


def scenario_findings(scenario: Scenario, samples: int, seed: int) -> tuple[Finding, ...]:
    """Return all findings of a scenario, those that take decisions included; a design that cannot be made is one.

    Args:
        scenario: The scenario.
        samples: Number of random states.
        seed: Seed of both.
    """
    try:
        findings = load_findings(scenario)
    except DesignError as error:
        return (_unmade(error),)
    if any(finding.severity is Severity.REFUSED for finding in findings):
        return findings
    design = design_of(scenario, robot_of(scenario))
    core = SafetyPassivityFilter(design, compiler=machine_code if design.gatekeeper else interpreted)
    plant, n = scenario.plant, core.design.system.n
    low, high = plant.start_low or (-WIDTH,) * n, plant.start_high or (WIDTH,) * n
    of_rows = row_findings(core, StateBox(x0=plant.x0, low=low, high=high), samples, seed)
    return (*findings, *of_rows, decision_time_finding(core, plant.x0, seed))


def _play_out(scenario: Scenario) -> Iterator[Finding]:
    periods = round(scenario.plant.playout_s * scenario.rate_hz)
    found = f"{scenario.plant.playout_s:g} s, {periods} periods"
    if periods >= 1:
        yield Finding(severity=Severity.NOTE, topic="play-out", subject="plant.playout_s", found=found)
    else:
        yield Finding(
            severity=Severity.WARNING,
            topic="play-out",
            subject="plant.playout_s",
            found=found,
            advice=f"at least one period, {scenario.dt_s:g} s: an input that is late for its period has no effect",
        )


def _unmade(error: DesignError) -> Finding:
    return Finding(
        severity=Severity.REFUSED,
        topic="design",
        subject=error.field,
        found=f"{error.got}",
        advice=f"allowed is {error.allowed}",
    )
