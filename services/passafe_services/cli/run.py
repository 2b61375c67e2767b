"""``passafe run``: one process of the system, for containers, other hosts and a person at a keyboard."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from passafe_services.cli.failure import with_one_line
from passafe_services.cli.options import DEFAULT_ROUTER, DEFAULT_SCENARIO, RouterOption, ScenarioOption, parse_endpoint
from passafe_services.loop.process_options import Device, ProcessName, ProcessOptions
from passafe_services.scenarios.load import load_scenario


def run(
    process: Annotated[ProcessName, typer.Argument(help="Which process.")],
    scenario: ScenarioOption = DEFAULT_SCENARIO,
    router: RouterOption = DEFAULT_ROUTER,
    device: Annotated[Device, typer.Option(help="operator: the scenario's script, or a keyboard.")] = Device.SCRIPT,
    duration: Annotated[float | None, typer.Option(min=0.0, help="plant: seconds of plant time, then end.")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="recorder: MCAP log to write.")] = Path("run.mcap"),
    port: Annotated[int, typer.Option(min=1, max=65535, help="dashboard: port of its page.")] = 8080,
    host: Annotated[str, typer.Option(help="dashboard: address of its page.")] = "127.0.0.1",
    lifeline: Annotated[
        bool, typer.Option("--lifeline", help="End when standard input does; used by `passafe demo`.")
    ] = False,
) -> None:
    """Run one process until Ctrl-C.

    All processes of a system take the same scenario and find each other through the router.

    Example: `passafe run operator --device keyboard` drives the robot of a running demo.
    """
    options = ProcessOptions(
        scenario=load_scenario(scenario),
        endpoint=parse_endpoint(router),
        device=device,
        duration_s=duration,
        out=out,
        port=port,
        host=host,
        lifeline=lifeline,
    )
    package = "passafe_dashboard" if process is ProcessName.DASHBOARD else f"passafe_services.{process}"
    import_module(f"{package}.process").start(options)


if __name__ == "__main__":  # what `passafe demo` starts: without the imports of the other commands
    app = typer.Typer(pretty_exceptions_enable=False)
    app.command()(run)
    with_one_line(app)
