"""The child processes of ``passafe demo``: how they are started, and how they are found again."""

import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Final

from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import GRACE_S, ProcessSpec, RestartPolicy
from passafe_services.loop.router_endpoint import RouterEndpoint

RESTARTED: Final = (ProcessName.ROUTER, ProcessName.DASHBOARD, ProcessName.OPERATOR, ProcessName.FILTER)
"""Processes that ``--restart`` starts again: not the recorder, whose log would be in two parts, nor the plant, the
robot."""

_RECORDER_GRACE_S: Final = 20.0
"""How long the recorder may take to end: on a busy machine it has a backlog to write."""

_MODULE: Final = ("-m", "passafe_services.cli.run")
_ROUTER: Final = "--router"


def demo_processes(
    scenario_file: Path,
    endpoint: RouterEndpoint,
    log: Path,
    *,
    robot: str,
    keys: Path | None,
    page_port: int | None,
    duration_s: float | None,
    restart: bool,
    rotation: Sequence[str] = (),
) -> list[ProcessSpec]:
    """Return the processes in the order in which they start; the plant last, so that it is stopped first.

    Args:
        scenario_file: Effective scenario, the same for all of them.
        endpoint: Where the router listens.
        log: MCAP log that the recorder writes.
        robot: Name of the robot.
        keys: Folder of the deployment's keys; ``None``: no TLS and no access control.
        page_port: Port of the dashboard's page; ``None``: no dashboard.
        duration_s: Plant time after which the plant ends, s; ``None``: never.
        rotation: Options of the recorder, see ``rotation_options``.
        restart: Whether those of ``RESTARTED`` are started again when they die.
    """
    duration = [] if duration_s is None else ["--duration", str(duration_s)]
    arguments: dict[ProcessName, list[str]] = {
        ProcessName.ROUTER: [],
        ProcessName.RECORDER: ["--out", str(log), *rotation, *duration],
        ProcessName.DASHBOARD: ["--port", str(page_port)],
        ProcessName.OPERATOR: [],
        ProcessName.FILTER: [],
        ProcessName.PLANT: duration,
    }
    if page_port is None:
        del arguments[ProcessName.DASHBOARD]
    router = [_ROUTER, f"{endpoint.host}:{endpoint.port}"]
    access = ["--insecure"] if keys is None else ["--keys", str(keys)]
    common = ["--scenario", str(scenario_file), *router, "--robot", robot, *access, "--lifeline"]
    return [
        ProcessSpec(
            name=name,
            argv=(sys.executable, "-P", *_MODULE, name, *common, *own),
            epoch_option="--epoch",
            grace_s=_RECORDER_GRACE_S if name is ProcessName.RECORDER else GRACE_S,
            restarts=RestartPolicy() if restart and name in RESTARTED else None,
        )
        for name, own in arguments.items()
    ]


def rotation_options(rotate_mb: float | None, rotate_s: float | None) -> tuple[str, ...]:
    """Return the recorder's options for files of a size, MB, and of a time, s."""
    given = {"--rotate-mb": rotate_mb, "--rotate-s": rotate_s}
    return tuple(text for option, value in given.items() if value is not None for text in (option, str(value)))


def is_demo_process(argv: Sequence[str], name: ProcessName, endpoint: RouterEndpoint) -> bool:
    """Return whether a command line is that of a demo's process, of the demo whose router listens at ``endpoint``."""
    option = (_ROUTER, f"{endpoint.host}:{endpoint.port}")
    return tuple(argv[2:5]) == (*_MODULE, name) and option in pairwise(argv)
