"""``passafe whatif``: re-run a log under other conditions."""

import json as json_text
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, get_args

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, TimeRemainingColumn

from passafe_services.cli.compare import AlignOption, HtmlOption, SvgOption, draw_overlay
from passafe_services.cli.comparison_table import print_comparison
from passafe_services.cli.errors import OptionError
from passafe_services.cli.options import LawOption, LinkOption, ModeOption, require_unset, writable_folder
from passafe_services.cli.output_files import require_separate
from passafe_services.cli.what_if_options import (
    HUMAN,
    OPERATORS,
    RECORDED,
    changed_scenario,
    interval_of,
    overrides_of,
)
from passafe_services.cli.what_if_search import SearchedRun, search_and_exit
from passafe_services.log.log_files import files_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.tools.compare.comparison import Comparison
from passafe_services.tools.compare.run_metrics import ReviewedRun
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.human_fit import HumanFit, fit_human, fitted
from passafe_services.tools.what_if.notes import notes_of
from passafe_services.tools.what_if.rerun import Conditions, Links
from passafe_services.tools.what_if.what_if import Question, WhatIf


@dataclass(frozen=True, kw_only=True)
class Asked:
    """Question of the command line.

    Attributes:
        file: Scenario to take instead of the log's; ``None``: the log's.
        overrides: Values of it, by dotted name.
        operator: Operator as typed.
        links: Whether links do what they did, or draw anew.
        seed: Of what is drawn.
    """

    file: str | None
    overrides: dict[str, Any]
    operator: str
    links: Links
    seed: int

    def conditions(self, log: RunLog, more: dict[str, Any]) -> tuple[Conditions, HumanFit | None]:
        """Return the conditions of a re-run, and how well a person fits the log if one drives.

        Args:
            log: The log.
            more: Further values of the scenario.

        Raises:
            PassafeError: The scenario or its operator cannot be used.
        """
        scenario = changed_scenario(log.identity.scenario, self.file, self.overrides | more)
        fit = fit_human(log, scenario) if self.operator == HUMAN else None
        if fit is not None:
            scenario = _driven_by(scenario, fit)
        acts = self.operator != RECORDED
        return Conditions(scenario=scenario, operator_acts=acts, links=self.links, seed=self.seed), fit

    def words(self, fit: HumanFit | None) -> str:
        """Return who drives instead of the recorded commands; empty: nobody."""
        if self.operator == RECORDED:
            return ""
        return "the scenario's own source" if fit is None else fit.text


def whatif(
    run: Annotated[Path, typer.Argument(metavar="LOG", help="MCAP log of a run, live or simulated.")],
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Any key of a scenario, e.g. filter.k_i=5; repeat for others."),
    ] = None,
    link: LinkOption = None,
    mode: ModeOption = None,
    law: LawOption = None,
    scenario: Annotated[
        str | None, typer.Option("--scenario", "-s", metavar="NAME|FILE", help="Scenario instead of the log's.")
    ] = None,
    operator: Annotated[str, typer.Option("--operator", metavar="WHO", help=f"Who drives: {OPERATORS}.")] = RECORDED,
    links: Annotated[
        str, typer.Option("--links", metavar="HOW", help="Unchanged links: as recorded, or drawn anew.")
    ] = "recorded",
    seed: Annotated[int, typer.Option("--seed", min=1, help="Of links that are drawn anew.")] = 1,
    out: Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="MCAP log to write.")] = None,
    search: Annotated[
        str | None,
        typer.Option("--search", metavar="KEY=LOW..HIGH", help="Find the value at which the verdict changes."),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option("--tolerance", metavar="WIDTH", help="Width at which a search ends; 1 % by default."),
    ] = None,
    runs: Annotated[int, typer.Option("--runs", metavar="N", min=2, help="Most runs of a search.")] = 20,
    align: AlignOption = "start",
    svg: SvgOption = None,
    html: HtmlOption = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
) -> None:
    """Run a log again in closed loop, with something changed: link, gain, barrier, law, mode, robot, operator.

    Plant and filter run again in virtual time, at the times at which they took their steps. The operator's commands
    are those of the log, at their times, whatever the robot does here: open loop in the person, and said so wherever
    the result is shown. Unchanged links lose and delay the messages that they did. With nothing changed, all ticks and
    states are those of the log to the last bit; otherwise the first difference is named, with the change that explains
    it.

    Exits with 0 when the run was made; with nothing changed, only if it is exact.

    Examples:
    - `passafe whatif run.mcap --link plant-to-filter:delay=0.15 --out slow.mcap`
    - `passafe whatif run.mcap --set filter.k_i=5 --set barriers.0.class_k.0.gain=2 --out tuned.mcap --html tuned.html`
    - `passafe whatif run.mcap --search link.plant-to-filter.delay=0..0.5` asks how much delay it would have borne
    - `passafe whatif run.mcap --operator human --mode off --out alone.mcap`
    """
    if links not in get_args(Links):
        raise OptionError("--links", repr(links), ", ".join(get_args(Links)))
    inputs = (*files_of(run), *(Path(given) for given in (scenario,) if given))
    require_separate({"--out": out, "--svg": svg, "--html": html}, inputs)
    overrides = overrides_of(settings or (), link or (), mode=mode, law=law, operator=operator)
    how: Links = "drawn" if links == "drawn" else "recorded"
    asked = Asked(file=scenario, overrides=overrides, operator=operator, links=how, seed=seed)
    question = Question.of(RunLog.read(run))
    if search is not None:
        interval = interval_of(search)
        require_unset(overrides, interval.field, "--search")
        attempt = SearchedRun(question, interval.field, lambda more: asked.conditions(question.log, more)[0])
        search_and_exit(attempt, interval, tolerance=tolerance, most_runs=runs, json=json)
    conditions, fit = asked.conditions(question.log, {})
    target = _new_log(out)
    result = _rerun(question, conditions, target, asked.words(fit))
    reviewed = [ReviewedRun.of(question.log), ReviewedRun.of(RunLog.read(target))]
    comparison = Comparison.of(reviewed, align)
    notes = tuple(f"{what}: {words}" for what, words in notes_of(result, fit))
    draw_overlay(reviewed, comparison, ["log", "what if"], svg=svg, html=html, notes=notes)
    if json:
        parts = {"what_if": result, "human": fit, "comparison": comparison}
        values = {name: None if part is None else part.model_dump(mode="json") for name, part in parts.items()}
        typer.echo(json_text.dumps(values, indent=2))
    else:
        _print(result, fit, comparison, target)
    is_unchanged = not result.changes and how == operator == RECORDED
    raise typer.Exit(1 if is_unchanged and not result.is_exact else 0)


def _new_log(out: Path | None) -> Path:
    """Return the log to write."""
    if out is None:
        raise OptionError("--out", "nothing", "a file for the log of the re-run; a search needs none")
    writable_folder(out.parent)
    return out


def _rerun(question: Question, conditions: Conditions, target: Path, operator: str) -> WhatIf:
    with Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn(), console=Console(stderr=True)) as bar:
        task = bar.add_task("running again", total=None)
        return question.answer(
            conditions,
            target,
            operator=operator,
            progress=lambda done, number: bar.update(task, completed=done, total=number),
        )


def _print(result: WhatIf, fit: HumanFit | None, comparison: Comparison, target: Path) -> None:
    console = Console(highlight=False)
    print_comparison(console, comparison, ["log", "what if"])
    for what, words in notes_of(result, fit):
        console.print(f"{what:<10}{escape(words)}", soft_wrap=True)
    console.print(f"log       {target}", soft_wrap=True)


def _driven_by(scenario: Scenario, fit: HumanFit) -> Scenario:
    source = scenario.operator.source
    if not isinstance(source, HumanSource):
        return scenario
    return scenario.model_copy(
        update={"operator": scenario.operator.model_copy(update={"source": fitted(source, fit)})}
    )
