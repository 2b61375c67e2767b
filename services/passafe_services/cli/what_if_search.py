"""Search of ``passafe whatif``: runs one value after the other, shows them, and prints what was found."""

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from passafe.errors import PassafeError
from passafe_services.cli.errors import OptionError
from passafe_services.cli.failure import INTERRUPTED
from passafe_services.cli.what_if_options import Interval
from passafe_services.simulation import CompiledScenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.what_if.rerun import Conditions
from passafe_services.tools.what_if.search import Search, SearchResult, Trial
from passafe_services.tools.what_if.what_if import Question

REFUSED_VALUE: Final = "refused"
"""Verdict on a value that makes no run."""

USUAL_TOLERANCE: Final = 0.01
"""Width of the interval at which a search ends, as a share of what is searched."""


class SearchedRun:
    """Makes the run of one value and judges it."""

    def __init__(self, question: Question, field: str, conditions: Callable[[dict[str, Any]], Conditions]) -> None:
        """Keep the log.

        Args:
            question: The log.
            field: Dotted name of the value in a scenario.
            conditions: Returns the conditions of a run with further values of the scenario.
        """
        self._question = question
        self._field = field
        self._conditions = conditions
        self._compiled: tuple[str, CompiledScenario] | None = None

    def __call__(self, value: float) -> Trial:
        """Run with this value; a value that the scenario refuses is an outcome, too."""
        try:
            conditions = self._conditions({self._field: value})
            compiled = self._compile(conditions)
        except PassafeError as error:
            return Trial(value=value, verdict=REFUSED_VALUE, h_min=None, words=str(error))
        with TemporaryDirectory() as scratch:
            path = Path(scratch) / "run.mcap"
            self._question.answer(conditions, path, compiled=compiled)
            verdict = Verdict.of(RunLog.read(path), CoreEvaluator(conditions.scenario))
        return Trial(value=value, verdict=verdict.verdict, h_min=verdict.h_min, words=verdict.words)

    def _compile(self, conditions: Conditions) -> CompiledScenario:
        """Return the compiled scenario, that of the run before if it is the same."""
        key = CompiledScenario.key_of(conditions.scenario)
        if self._compiled is None or self._compiled[0] != key:
            self._compiled = (key, CompiledScenario.of(conditions.scenario))
        return self._compiled[1]


def search_and_exit(
    attempt: SearchedRun, interval: Interval, *, tolerance: float | None, most_runs: int, json: bool
) -> NoReturn:
    """Search, print the result, and exit: 0 when it is as narrow as asked, 1 when not, 130 after Ctrl-C.

    Args:
        attempt: Makes the runs.
        interval: Where to search.
        tolerance: Width at which to end; ``None``: a share of the interval.
        most_runs: Largest number of runs.
        json: Whether to print one JSON object.

    Raises:
        OptionError: A tolerance that is not above 0, or a key none of whose values makes a run.
    """
    width = USUAL_TOLERANCE * (interval.high - interval.low) if tolerance is None else tolerance
    if not width > 0:
        raise OptionError("--tolerance", f"{width:g}", "a width above 0")
    search = Search(key=interval.key, low=interval.low, high=interval.high, tolerance=width, most_runs=most_runs)
    console, shown = Console(highlight=False), Console(highlight=False, stderr=True)
    number = 0

    def tell(value: float) -> Trial:
        nonlocal number
        number += 1
        trial = attempt(value)
        shown.print(f"run {number} of at most {most_runs}: {interval.key} {value:.6g}: {trial.verdict}")
        return trial

    result = search.run(tell)
    if result.is_finished and all(trial.verdict == REFUSED_VALUE for trial in result.trials):
        first = result.trials[0]
        got = f"{interval.key!r} with {len(result.trials)} values, all refused"
        raise OptionError("--search", got, f"values that a scenario may have; of {first.value:g}: {first.words}")
    if json:
        typer.echo(result.model_dump_json(indent=2))
    else:
        _print(console, result)
    raise typer.Exit(INTERRUPTED if result.was_interrupted else 0 if result.is_finished else 1)


def _print(console: Console, result: SearchResult) -> None:
    table = Table(result.key, "verdict", "smallest h", "why", title_justify="left")
    for trial in result.trials:
        lowest = "" if trial.h_min is None else f"{trial.h_min:.3g}"
        table.add_row(f"{trial.value:.6g}", trial.verdict, lowest, escape(trial.words))
    console.print(table)
    console.print(result.text, soft_wrap=True)
