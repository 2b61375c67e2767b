"""The console script ``passafe``: its commands, and one clear line for whatever goes wrong in them."""

import sys
from typing import Final

import typer

from dashboard.errors import DashboardError
from passafe.errors import PassafeError
from protocol.errors import ProtocolError
from services.cli import demo, recover, replay, review, run, scenarios, simulate
from services.operator.errors import OperatorError
from services.recorder.errors import LogFileError
from services.review.errors import ReviewError
from services.runtime.errors import RuntimeFault
from services.scenarios.errors import ScenarioError

REFUSED: Final = 2
"""Exit code for input that cannot be used, and for what keeps a command from doing its work."""

EXPECTED: Final = (
    DashboardError,
    LogFileError,
    OperatorError,
    PassafeError,
    ProtocolError,
    ReviewError,
    RuntimeFault,
    ScenarioError,
)

app = typer.Typer(
    name="passafe",
    help="Keeps a teleoperated robot safe and passive while a person drives it over a bad network.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
app.command("demo")(demo.demo)
app.command("run")(run.run)
app.command("simulate")(simulate.simulate)
app.command("review")(review.review)
app.command("replay")(replay.replay)
app.command("recover")(recover.recover_log)
app.command("scenarios")(scenarios.scenarios)


def main() -> None:
    """Run the command line and leave with its exit code."""
    try:
        app()
    except EXPECTED as error:
        sys.stderr.write(f"passafe: {' '.join(str(error).split())}\n")
        sys.exit(REFUSED)
