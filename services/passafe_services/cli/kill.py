"""``passafe kill``: kill a process of a running demo."""

import os
from typing import Annotated

import psutil
import typer

from passafe_services.cli.bus_options import DEFAULT_ROUTER, RouterOption, parse_endpoint
from passafe_services.cli.demo_processes import is_demo_process
from passafe_services.cli.errors import OptionError
from passafe_services.loop.process_name import ProcessName


def kill(
    process: Annotated[ProcessName, typer.Argument(metavar="PROCESS", help="Process of the demo.")],
    router: RouterOption = DEFAULT_ROUTER,
) -> None:
    """Kill a process of a demo on this machine (SIGKILL), to see what the robot does without it.

    Only your own processes are killed, and only those of the demo with that router. A demo with `--restart` starts
    the process again.

    Example: `passafe kill filter`
    """
    endpoint = parse_endpoint(router)
    found = [
        each
        for each in psutil.process_iter(["cmdline", "uids"])
        if each.info["cmdline"]
        and each.info["uids"].real == os.getuid()
        and is_demo_process(each.info["cmdline"], process, endpoint)
    ]
    if not found:
        raise OptionError("PROCESS", process, f"a process of a demo on this machine with its router at {router}")
    for each in found:
        each.kill()
        typer.echo(f"killed {process} (process {each.pid})")
