"""The child processes of ``passafe demo``: how they are started, and how they are found again."""

import sys
from collections.abc import Sequence
from dataclasses import replace
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


CONTROL_OPTION: Final = "--control-channel"
"""Option of the dashboard for the channel over which its page starts and ends runs."""


class DemoProcesses:
    """Processes of one demo.

    Args:
        endpoint: Where the router listens.
        robot: Name of the robot.
        keys: Folder of the deployment's keys; ``None``: no TLS and no access control.
        page_port: Port of the dashboard's page; ``None``: no dashboard.
        runs: Folder of the logs and experiments that the page shows; ``None``: none.
        duration_s: Plant time after which the plant ends, s; ``None``: never.
        restart: Whether those of ``RESTARTED`` are started again when they die.
        rotation: Options of the recorder, see ``rotation_options``.
    """

    def __init__(
        self,
        endpoint: RouterEndpoint,
        *,
        robot: str,
        keys: Path | None,
        page_port: int | None,
        runs: Path | None = None,
        duration_s: float | None,
        restart: bool,
        rotation: Sequence[str] = (),
    ) -> None:
        access = ["--insecure"] if keys is None else ["--keys", str(keys)]
        self._common = [_ROUTER, f"{endpoint.host}:{endpoint.port}", "--robot", robot, *access, "--lifeline"]
        self._page_port = page_port
        self._runs = [] if runs is None else ["--runs", str(runs)]
        self._duration = [] if duration_s is None else ["--duration", str(duration_s)]
        self._restart = restart
        self._rotation = tuple(rotation)

    def of_session(self, scenario_file: Path) -> tuple[ProcessSpec, ...]:
        """Return those that stay while runs come and go, in the order in which they start.

        Args:
            scenario_file: Effective scenario of the first run.
        """
        router = self._spec(ProcessName.ROUTER, scenario_file)
        if self._page_port is None:
            return (router,)
        page = self._spec(ProcessName.DASHBOARD, scenario_file, "--port", str(self._page_port), *self._runs)
        return router, replace(page, control_option=CONTROL_OPTION)

    def of_run(self, scenario_file: Path, log: Path | None, *, start_stopped: bool = False) -> tuple[ProcessSpec, ...]:
        """Return those of one run, in the order in which they start; the plant last, so that it is stopped first.

        Args:
            scenario_file: Effective scenario, the same for all of them.
            log: MCAP log that the recorder writes; ``None``: no recorder.
            start_stopped: Whether the plant starts with the emergency stop latched.
        """
        stopped = ("--start-stopped",) if start_stopped else ()
        recorder = self._spec(ProcessName.RECORDER, scenario_file, "--out", str(log), *self._rotation, *self._duration)
        return (
            *(() if log is None else (recorder,)),
            self._spec(ProcessName.OPERATOR, scenario_file),
            self._spec(ProcessName.FILTER, scenario_file),
            self._spec(ProcessName.PLANT, scenario_file, *self._duration, *stopped),
        )

    def _spec(self, name: ProcessName, scenario_file: Path, *own: str) -> ProcessSpec:
        return ProcessSpec(
            name=name,
            argv=(sys.executable, "-P", *_MODULE, name, "--scenario", str(scenario_file), *self._common, *own),
            epoch_option="--epoch",
            grace_s=_RECORDER_GRACE_S if name is ProcessName.RECORDER else GRACE_S,
            restarts=RestartPolicy() if self._restart and name in RESTARTED else None,
        )


def rotation_options(rotate_mb: float | None, rotate_s: float | None) -> tuple[str, ...]:
    """Return the recorder's options for files of a size, MB, and of a time, s."""
    given = {"--rotate-mb": rotate_mb, "--rotate-s": rotate_s}
    return tuple(text for option, value in given.items() if value is not None for text in (option, str(value)))


def is_demo_process(argv: Sequence[str], name: ProcessName, endpoint: RouterEndpoint) -> bool:
    """Return whether a command line is that of a demo's process, of the demo whose router listens at ``endpoint``."""
    option = (_ROUTER, f"{endpoint.host}:{endpoint.port}")
    return tuple(argv[2:5]) == (*_MODULE, name) and option in pairwise(argv)
