"""Assembles the command line ``passafe`` from its commands."""

from typing import Annotated

import typer

from passafe_services.cli import (
    browse,
    campaign,
    check,
    compare,
    demo,
    experiment,
    export,
    feasibility,
    health,
    identify,
    keys,
    kill,
    link,
    recover,
    replay,
    review,
    run,
    scenarios,
    simulate,
    stop,
    whatif,
)
from passafe_services.cli.failure import run_reporting_errors
from passafe_services.cli.version import version_text

app = typer.Typer(
    name="passafe",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(version_text())
        raise typer.Exit


@app.callback()
def options_of_all_commands(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Keep a teleoperated robot safe and passive while a person drives it over a bad network.

    First steps: `passafe demo` runs the whole system and prints the address of its page; `passafe COMMAND --help`
    explains a command.
    """


LIVE = "Run a system live"
VIRTUAL = "Run in virtual time"
LOGS = "Read logs"
app.command("demo", rich_help_panel=LIVE)(demo.demo)
app.command("run", rich_help_panel=LIVE)(run.run)
app.add_typer(link.app, name="link", rich_help_panel=LIVE)
app.command("health", rich_help_panel=LIVE)(health.health)
app.command("stop", rich_help_panel=LIVE)(stop.stop)
app.command("clear", rich_help_panel=LIVE)(stop.clear)
app.add_typer(keys.app, name="keys", rich_help_panel=LIVE)
app.command("kill", rich_help_panel=LIVE)(kill.kill)
app.command("scenarios", rich_help_panel=LIVE)(scenarios.scenarios)
app.command("check", rich_help_panel=VIRTUAL)(check.check)
app.command("simulate", rich_help_panel=VIRTUAL)(simulate.simulate)
app.command("experiment", rich_help_panel=VIRTUAL)(experiment.experiment)
app.command("campaign", rich_help_panel=VIRTUAL)(campaign.campaign)
app.command("feasibility", rich_help_panel=VIRTUAL)(feasibility.feasibility)
app.command("browse", rich_help_panel=LOGS)(browse.browse)
app.command("review", rich_help_panel=LOGS)(review.review)
app.command("replay", rich_help_panel=LOGS)(replay.replay)
app.command("whatif", rich_help_panel=LOGS)(whatif.whatif)
app.command("compare", rich_help_panel=LOGS)(compare.compare)
app.command("identify", rich_help_panel=LOGS)(identify.identify_robot)
app.command("recover", rich_help_panel=LOGS)(recover.recover_log)
app.command("export", rich_help_panel=LOGS)(export.export)


def main() -> None:
    """Run the command line and exit with its code."""
    run_reporting_errors(app)
