"""``passafe check``: judge a scenario before anything moves."""

import json as json_text
from dataclasses import asdict
from typing import Annotated, Final

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from passafe.finding import Finding, Severity, worst
from passafe_services.cli.failure import REFUSED
from passafe_services.cli.robot_option import OwnRobotOption
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.check.scenario_check import load_warnings, scenario_findings

STYLES: Final = {Severity.REFUSED: "bold red", Severity.WARNING: "yellow", Severity.NOTE: "dim"}
CODES: Final = {Severity.REFUSED: REFUSED, Severity.WARNING: 1, Severity.NOTE: 0}


def check(
    scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="Shipped scenario or TOML file.")],
    samples: Annotated[
        int, typer.Option("--samples", "-n", metavar="N", min=8, max=100_000, help="Number of states of each kind.")
    ] = 400,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of states and operators.")] = 1,
    robot: OwnRobotOption = None,
    json: Annotated[bool, typer.Option("--json", help="Print the findings as one JSON list.")] = False,
) -> None:
    """Check a scenario before anything moves.

    Looks at the relative degree of every barrier, the set that its start is in, whether the plant's fail-safe keeps
    every barrier when its inputs are held for a period, the limits of the input, the storage function, play-out and
    loop rate, and decides in random states and drives from the start at the limits: how often can the rows be kept,
    with the margins between samples and without? Every finding says what, with which value, and what to change.

    Takes seconds, but minutes where the filter compares courses in most periods of a fast loop: fewer samples then.

    Commands that run a scenario print its warnings too, except those that take decisions, and refuse what cannot be
    used. Exits with 0 if there are only notes, with 1 after a warning, with 2 if the scenario cannot be used.

    Example: `passafe check walls-and-disks`
    """
    chosen = load_scenario(scenario, robot=robot)
    with Console(stderr=True).status("deciding in random states, then driving from the start"):
        findings = scenario_findings(chosen, samples, seed)
    if json:
        typer.echo(json_text.dumps([asdict(one) | {"severity": one.severity.value} for one in findings], indent=2))
    else:
        _show(chosen, findings)
    raise typer.Exit(CODES[worst(findings)])


def _show(scenario: Scenario, findings: tuple[Finding, ...]) -> None:
    console = Console(highlight=False)
    table = Table("", "what", "of", "found", title=f"{scenario.name}: before it runs", title_justify="left")
    alike: dict[tuple[Severity, str, str, str], list[str]] = {}
    for one in findings:
        alike.setdefault((one.severity, one.topic, one.found, one.advice), []).append(one.subject)
    for (severity, topic, found, advice), subjects in alike.items():
        words = escape(found) + (f"\n→ {escape(advice)}" if advice else "")
        table.add_row(f"[{STYLES[severity]}]{severity.value}[/]", topic, escape(", ".join(subjects)), words)
    console.print(table)
    counts = {severity: sum(one.severity is severity for one in findings) for severity in Severity}
    console.print(", ".join(f"{severity.value} {count}" for severity, count in counts.items() if count))


def warn_at_load(scenario: Scenario) -> None:
    """Print the warnings of a scenario on standard error, one line each.

    Raises:
        UnusableScenarioError: The scenario cannot be used.
    """
    console = Console(stderr=True, highlight=False, soft_wrap=True, markup=False)
    for finding in load_warnings(scenario):
        console.print(f"warning: {finding}")
