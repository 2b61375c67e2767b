"""``passafe stop`` and ``passafe clear``: the emergency stop of a running system."""

import time
from typing import Annotated

import typer
from passafe_protocol.keys import DEFAULT_ROBOT, require_robot_name

from passafe_services.cli.access_options import InsecureOption, KeysOption, secured_endpoint
from passafe_services.cli.bus_options import DEFAULT_ROUTER, RobotOption, RouterOption
from passafe_services.cli.failure import run_reporting_errors
from passafe_services.loop.stop_console import ANSWER_S, SOURCE, open_stop_console

WaitOption = Annotated[
    float, typer.Option("--wait", metavar="SECONDS", min=0.1, max=3600.0, help="Time to wait for the plant's answer.")
]


def stop(
    reason: Annotated[str, typer.Argument(metavar="[REASON]", help="Why, for the log.")] = "pressed at a terminal",
    router: RouterOption = DEFAULT_ROUTER,
    robot: RobotOption = DEFAULT_ROBOT,
    keys: KeysOption = None,
    insecure: InsecureOption = False,
    wait: WaitOption = ANSWER_S,
) -> None:
    """Press the emergency stop: the robot's own fail-safe law takes over at once, whatever else runs or does not.

    The plant latches the stop: no input moves the robot until somebody clears it with `passafe clear` or on the page.
    The press is repeated until the plant acknowledges it; without an answer the exit code is not 0.

    Examples:
    - `passafe stop`
    - `passafe stop "a person in the way" --robot arm-2`
    """
    endpoint = secured_endpoint(router, SOURCE, require_robot_name(robot), keys=keys, insecure=insecure)
    with open_stop_console(endpoint, robot=robot, answer_s=wait) as console:
        pressed_s = time.monotonic()
        state = console.press(reason)
    took_ms = 1e3 * (time.monotonic() - pressed_s)
    typer.echo(f"stopped at plant time {state.plant_ns / 1e9:.3f} s, acknowledged after {took_ms:.0f} ms")
    typer.echo("it stays stopped until `passafe clear`")


def clear(
    reason: Annotated[str, typer.Argument(metavar="[REASON]", help="Why, for the log.")] = "cleared at a terminal",
    router: RouterOption = DEFAULT_ROUTER,
    robot: RobotOption = DEFAULT_ROBOT,
    keys: KeysOption = None,
    insecure: InsecureOption = False,
    wait: WaitOption = ANSWER_S,
) -> None:
    """Clear the emergency stop that is latched now: the robot can be driven again.

    Make sure first that the way is free: a script goes on at once, a person has to let go of the device and press it
    again. Nothing that was commanded or decided before the clear moves the robot. If somebody presses the stop again
    meanwhile, it stays latched and the exit code is not 0.

    Example: `passafe clear "the way is free"`
    """
    endpoint = secured_endpoint(router, SOURCE, require_robot_name(robot), keys=keys, insecure=insecure)
    with open_stop_console(endpoint, robot=robot, answer_s=wait) as console:
        state = console.clear(reason)
    if state is None:
        typer.echo("no emergency stop is latched")
    else:
        typer.echo(f"cleared at plant time {state.plant_ns / 1e9:.3f} s")


def main() -> None:
    """Run one of these two commands and exit with its code, without loading the others: a press must not wait."""
    app = typer.Typer(name="passafe", add_completion=False, pretty_exceptions_enable=False)
    app.command("stop")(stop)
    app.command("clear")(clear)
    run_reporting_errors(app)
