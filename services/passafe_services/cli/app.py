"""The console script ``passafe``: its commands, and one clear line for whatever goes wrong in them."""

from typing import Annotated

import typer

from passafe_services.cli import (
    campaign,
    demo,
    experiment,
    feasibility,
    kill,
    link,
    recover,
    replay,
    review,
    run,
    scenarios,
    simulate,
)
from passafe_services.cli.failure import with_one_line
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
    """Keep a teleoperated robot safe and passive while a person drives it over a bad network."""


app.command("demo")(demo.demo)
app.command("run")(run.run)
app.command("simulate")(simulate.simulate)
app.command("experiment")(experiment.experiment)
app.command("campaign")(campaign.campaign)
app.command("feasibility")(feasibility.feasibility)
app.command("review")(review.review)
app.command("replay")(replay.replay)
app.command("recover")(recover.recover_log)
app.command("kill")(kill.kill)
app.add_typer(link.app, name="link")
app.command("scenarios")(scenarios.scenarios)


def main() -> None:
    """Run the command line and leave with its exit code."""
    with_one_line(app)
