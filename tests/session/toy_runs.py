"""Sessions of runs whose processes are toys."""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

from passafe_services.loop.process_exit import RunOutcome
from passafe_services.loop.process_spec import ProcessSpec, RestartPolicy
from passafe_services.scenarios.load import load_scenario
from passafe_services.session.control_messages import RunChoices
from passafe_services.session.planned_run import PlannedRun
from passafe_services.session.run_session import Conclude, RunSession

SCENARIO = load_scenario("notomista-cai-2020")

TOY = """
import os, sys, signal
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
print(f"passafe-ready {sys.argv[1]}", flush=True)
signal.sigwait({signal.SIGTERM})
"""


def toy(name: str, *, restarts: RestartPolicy | None = None) -> ProcessSpec:
    """Return a process that is ready at once and ends on SIGTERM."""
    return ProcessSpec(name=name, argv=(sys.executable, "-S", "-c", TOY, name), restarts=restarts)


def toy_run(*names: str, log: str | None = None, specs: tuple[ProcessSpec, ...] = ()) -> PlannedRun:
    """Return a run of toys."""
    return PlannedRun(
        choices=RunChoices(scenario="-".join(names) or "none"),
        scenario=SCENARIO,
        scenario_file=Path("none.json"),
        log=None if log is None else Path(log),
        specs=specs or tuple(map(toy, names)),
        most_s=None,
    )


class Script:
    """Reports of a session that act: each callback may ask the session for something.

    Attributes:
        session: The session.
        outcomes: Outcome of each run, in order.
        ready_runs: Numbers of the runs that were ready.
        on_ready: Called with the number of a run that is ready.
        on_ended: Called with the number of a run that has ended.
        conclusions: What takes the verdicts, by the number of the run.
    """

    def __init__(self, first: PlannedRun, *base: ProcessSpec) -> None:
        self.session = RunSession(base or (toy("router"),), first, reports=self, scenarios=("a", "b"))
        self.outcomes: list[RunOutcome] = []
        self.began: list[bool] = []
        self.ready_runs: list[int] = []
        self.on_ready: Callable[[int], object] = lambda _number: None
        self.on_ended: Callable[[int], object] = lambda _number: None
        self.conclusions: dict[int, Conclude] = {}

    def ready(self, number: int, run: PlannedRun) -> None:
        """Note a run that is ready, and act."""
        del run
        self.ready_runs.append(number)
        self.on_ready(number)

    def ended(self, number: int, run: PlannedRun, outcome: RunOutcome, conclude: Conclude, *, began: bool) -> None:
        """Note a run that has ended, and act."""
        del run
        self.outcomes.append(outcome)
        self.began.append(began)
        self.conclusions[number] = conclude
        self.on_ended(number)


def press_ctrl_c() -> None:
    """Ask the supervisor, which is this process, to end."""
    os.kill(os.getpid(), signal.SIGINT)
