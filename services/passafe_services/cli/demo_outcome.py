"""Reports how a demo ended, and the verdict on its log."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.markup import escape

from passafe_services.cli.judging import judged
from passafe_services.cli.verdict import exit_code, print_verdict
from passafe_services.log.errors import LogFileError, LogReadError, LogWriteError
from passafe_services.log.log_files import files_of
from passafe_services.log.log_reader import LogReader
from passafe_services.loop.process_exit import ExitCause, RunOutcome
from passafe_services.loop.process_name import ProcessName
from passafe_services.tools.recover import recover
from passafe_services.tools.review.verdict import Verdict

DIED: Final = 3
"""Exit code if a process died for good, could not be started or did not end in time."""


def report_outcome(
    outcome: RunOutcome, log: Path, console: Console, on_verdict: Callable[[Verdict], None] | None = None
) -> int:
    """Print how the run ended, the verdict and the path of the log; return the exit code.

    Args:
        outcome: What the supervisor returned.
        log: The recorder's log; one that it did not finish is replaced by what can be recovered of it.
        console: Where to print.
        on_verdict: Called with the verdict, if there is one.
    """
    try:
        found = judged(log)
    except LogFileError as error:
        report_end(outcome, console, has_end=True)
        console.print(f"[bold red]this run has no log[/]: {escape(str(error))}")
        return DIED
    in_order = report_end(outcome, console, has_end=found.identity.planned_s is not None)
    print_verdict(found.verdict, log if found.verdict.finished else _recovered(log, console), console)
    if on_verdict is not None:
        on_verdict(found.verdict)
    return exit_code(found.verdict) if in_order else DIED


def report_end(outcome: RunOutcome, console: Console, *, has_end: bool) -> bool:
    """Print how the run ended if it did not end as it should; return whether it did.

    A run in order is ended by a signal, or, if it ``has_end``, by the plant.
    """
    too_long = outcome.cause is ExitCause.DURATION
    by_plant = has_end and outcome.culprit == ProcessName.PLANT
    deserted = outcome.cause is ExitCause.LEFT and not by_plant
    in_order = outcome.clean and not too_long and not deserted
    if not in_order:
        late = ", and the plant has not come to its end" if too_long else ""
        console.print(f"[bold red]{escape(outcome.detail)}{late}[/]")
    if outcome.killed_on_request:
        counts = ", ".join(f"{name} {count}" for name, count in outcome.killed_on_request.items())
        console.print(f"killed on request  {counts}", highlight=False)
    if outcome.restarts:
        counts = ", ".join(f"{name} {count}" for name, count in outcome.restarts.items())
        console.print(f"restarts  {counts}", highlight=False)
    return in_order


def _recovered(log: Path, console: Console) -> Path:
    """Put complete copies in the places of files that the recorder did not finish; return the path of what there is."""
    for file in files_of(log):
        reader = LogReader(file, alone=True)
        for _ in reader.records():
            pass
        if not reader.finished and (left := _replaced(file, console)) is not None:
            return left
    return log


def _replaced(file: Path, console: Console) -> Path | None:
    """Put a complete copy in the place of a file; return where it is if that is not possible."""
    torn = file.with_suffix(".torn.mcap")
    try:
        file.rename(torn)
        kept = recover(torn, file)
    except LogReadError as error:  # nothing is intact: most likely the last of several files, which was begun
        torn.rename(file)
        console.print(f"the recorder did not finish its log: {escape(str(error))}")
        return None
    except (OSError, LogWriteError) as error:  # most likely a full disk
        if torn.exists():
            file.unlink(missing_ok=True)
        left = torn if torn.exists() else file
        console.print(f"the recorder did not finish its log, and a copy cannot be written: {escape(str(error))}")
        console.print(f"what was recorded is in {left}; `passafe recover` completes it where there is room")
        return left
    console.print(f"the recorder did not finish its log; {kept.messages} messages were recovered from {torn}")
    return None
