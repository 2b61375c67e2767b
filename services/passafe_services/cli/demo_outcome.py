"""Reports how a demo ended, and the verdict on its log."""

from pathlib import Path
from typing import Final

from rich.console import Console

from passafe_services.cli.verdict import exit_code, print_verdict
from passafe_services.loop.process_exit import ExitCause, RunOutcome
from passafe_services.loop.process_name import ProcessName
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.recover import recover
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

DIED: Final = 3
"""Exit code if a process died for good, could not be started or did not end in time."""


def report_outcome(outcome: RunOutcome, log: Path, scenario: Scenario, console: Console) -> int:
    """Print how the run ended, the verdict and the path of the log; return the exit code.

    Args:
        outcome: What the supervisor returned.
        log: The recorder's log; one that it did not finish is replaced by what can be recovered of it.
        scenario: The effective scenario.
        console: Where to print.
    """
    too_long = outcome.cause is ExitCause.DURATION  # a run in order is ended by the plant, or by a signal
    deserted = outcome.cause is ExitCause.LEFT and outcome.culprit != ProcessName.PLANT
    in_order = outcome.clean and not too_long and not deserted
    if not in_order:
        console.print(f"[bold red]{outcome.detail}{', and the plant has not come to its end' if too_long else ''}[/]")
    if outcome.restarts:
        counts = ", ".join(f"{name} {count}" for name, count in outcome.restarts.items())
        console.print(f"restarts  {counts}", highlight=False)
    if not log.exists():
        return DIED
    read = RunLog.read(log)
    if not read.finished:
        torn = log.with_suffix(".torn.mcap")
        log.rename(torn)
        kept = recover(torn, log)
        console.print(f"the recorder did not finish its log; {kept.messages} messages were recovered from {torn}")
    verdict = Verdict.of(read, CoreEvaluator(scenario))
    print_verdict(verdict, log)
    return exit_code(verdict) if in_order else DIED
