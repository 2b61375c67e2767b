"""Prints a verdict to the terminal."""

from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from passafe_services.tools.review.steering import Steering
from passafe_services.tools.review.verdict import Verdict


def exit_code(verdict: Verdict) -> int:
    """Return 0 if every required property holds, 1 otherwise."""
    return 0 if verdict.verdict == "holds" else 1


def print_verdict(verdict: Verdict, log: Path, console: Console | None = None) -> None:
    """Print the properties of a run, its counts, and the path of its log.

    Args:
        verdict: What the review found.
        log: The log that was reviewed.
        console: Where to print; standard output if not given.
    """
    console = console or Console(highlight=False)
    console.print(_properties_table(verdict))
    if verdict.steering is not None:
        _print_steering(console, verdict.steering)
    final = "none" if verdict.final_x is None else ", ".join(f"{value:.4f}" for value in verdict.final_x)
    console.print(f"final x   {final}")
    _print_counts(console, verdict)
    for account in verdict.links:
        console.print(f"link      {account.text}", soft_wrap=True)
    console.print(
        f"verdict   [bold]{verdict.verdict}[/]{escape(verdict.words.removeprefix(verdict.verdict))}", soft_wrap=True
    )
    console.print(f"log       {log}", soft_wrap=True)


def _properties_table(verdict: Verdict) -> Table:
    title = f"{verdict.scenario}, mode {verdict.mode}, law {verdict.law}, {verdict.driver}"
    table = Table("property", "required", "holds", "worst", "allowed", "at", title=title, title_justify="left")
    for name, entry in verdict.properties.items():
        table.add_row(
            name,
            "yes" if entry.required else "no",
            {True: "yes", False: "[bold red]NO[/]", None: "unknown"}[entry.holds],
            _number(entry.worst),
            entry.allowed,
            "" if entry.at_s is None else f"{entry.at_s:.3f} s",
        )
    return table


def _print_counts(console: Console, verdict: Verdict) -> None:
    counts = ", ".join(f"{name} {count}" for name, count in verdict.status_counts.items())
    console.print(f"ticks     {verdict.ticks} ({counts}), {verdict.steps_skipped} missed")
    if verdict.commands.shares.keys() - {"counts"}:
        console.print(f"commands  {verdict.commands.text}", soft_wrap=True)
    if verdict.guard is not None:
        console.print(f"guard     {verdict.guard.in_words()}", soft_wrap=True)
    restarted = ", ".join(f"{name} {count}" for name, count in verdict.sessions.items() if count > 1)
    if restarted:
        console.print(f"sessions  {restarted}")
    if verdict.sequence_breaks:
        console.print(f"sequence breaks {verdict.sequence_breaks}, {verdict.without_input_s:.3f} s in all")
    if verdict.late_us_p99 is not None and verdict.solve_us_p50 is not None:
        console.print(
            f"timing    late p50 {verdict.late_us_p50:.0f} µs, p99 {verdict.late_us_p99:.0f} µs; "
            f"filter step p50 {verdict.solve_us_p50:.0f} µs, p99 {verdict.solve_us_p99:.0f} µs"
        )


def _print_steering(console: Console, steering: Steering) -> None:
    table = Table("target", "at", "reached after", "overshoot", "rms error", title="steering", title_justify="left")
    for leg in steering.legs:
        table.add_row(
            ", ".join(f"{value:g}" for value in leg.target),
            f"{leg.at_s:g} s",
            "not" if leg.time_to_target_s is None else f"{leg.time_to_target_s:.2f} s",
            f"{leg.overshoot:.3f}",
            f"{leg.rms_error:.3f}",
        )
    console.print(table)
    console.print(
        f"effort    {_number(steering.effort) or 'unknown'}, held back {_number(steering.held_back) or 'unknown'}; "
        f"{steering.collisions} collisions, {steering.collided_s:.2f} s"
    )


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}"
