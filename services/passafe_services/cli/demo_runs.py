"""Prepares the runs of a demo: the command line's, and those that its page requests."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Final

from passafe_services.cli.check import warn_at_load
from passafe_services.cli.demo_processes import DemoProcesses
from passafe_services.cli.demo_rate import limited_beside_page
from passafe_services.cli.errors import OptionError
from passafe_services.cli.log_name import log_name
from passafe_services.cli.options import scenario_from_options
from passafe_services.loop.realtime import available_processors
from passafe_services.scenarios.errors import UnknownScenarioError
from passafe_services.scenarios.load import shipped_scenarios
from passafe_services.scenarios.schema import Scenario
from passafe_services.session.control_messages import RunChoices, StartRun
from passafe_services.session.planned_run import PlannedRun

PATIENCE_S: Final = 60.0
"""How much longer than ``--duration`` a run may take by the clock: plant time begins with the filter's first input."""


@dataclass(frozen=True, kw_only=True, slots=True)
class DemoOptions:
    """Options of the command line that hold for all runs of a demo.

    Attributes:
        scenario: Its scenario, a name or a file.
        mode: What the filter enforces; ``None``: as the scenario says.
        law: Rows of the filter; ``None``: as the scenario says.
        duration_s: Plant time of a run, s; ``None``: no end.
        rate_hz: Ticks per second; ``None``: as the scenario says.
        links: Impaired links.
        has_page: Whether there is a page.
        folder: Folder of the logs.
        robot: ``FILE.py:FUNCTION`` of the user's robot, for the command line's scenario; ``None``: the scenario's own.
    """

    scenario: str
    mode: str | None
    law: str | None
    duration_s: float | None
    rate_hz: float | None
    links: tuple[str, ...]
    has_page: bool
    folder: Path
    robot: str | None = None

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Scenarios that the page may request: the shipped ones, and the one of the command line."""
        shipped = shipped_scenarios()
        return (*(() if self.scenario in shipped else (self.scenario,)), *shipped)

    def checked_scenario(self, choices: RunChoices, report: Callable[[str], object] = lambda _: None) -> Scenario:
        """Return the effective scenario of a run; warnings of its check are printed.

        Args:
            choices: What the run is to be.
            report: Called with a line for the user if the rate is limited.

        Raises:
            PassafeError: No such scenario, or one that cannot be used so.
        """
        if choices.scenario not in self.scenarios:
            raise UnknownScenarioError(choices.scenario, self.scenarios)
        rate_hz = choices.rate_hz or self.rate_hz
        scenario = scenario_from_options(
            choices.scenario,
            mode=choices.mode or self.mode,
            law=self.law,
            duration_s=self.duration_s,
            rate_hz=rate_hz,
            links=self.links,
            prediction=choices.prediction,
            gatekeeper=choices.gatekeeper,
            robot=self.robot if choices.scenario == self.scenario else None,
        )
        if rate_hz is None and self.has_page:
            scenario = limited_beside_page(scenario, available_processors(), report)
        warn_at_load(scenario)
        return scenario


def planned_run(request: StartRun, scenario: Scenario, options: DemoOptions, processes: DemoProcesses) -> PlannedRun:
    """Return a run that can be started; its scenario is written to a file.

    Args:
        request: What it is to be.
        scenario: Its effective scenario.
        options: What the command line says.
        processes: Makes its processes.

    Raises:
        OptionError: The folder cannot be written.
    """
    base = _unused(options.folder / log_name(scenario))
    effective = base.with_suffix(".scenario.json")
    log = base.with_suffix(".mcap") if request.choices.recording else None
    try:
        effective.write_text(scenario.model_dump_json(indent=2), encoding="utf-8")
    except OSError as error:
        raise OptionError("--out", f"{options.folder} ({error.strerror})", "a folder with room for a log") from error
    return PlannedRun(
        choices=request.choices,
        scenario=scenario,
        scenario_file=effective,
        log=log,
        specs=processes.of_run(effective, log, start_stopped=request.start_stopped),
        most_s=None if options.duration_s is None else options.duration_s + PATIENCE_S,
    )


def _unused(base: Path) -> Path:
    """Return the path, numbered if another run of the same second has it."""
    candidates = (base if number == 1 else base.with_name(f"{base.name}-{number}") for number in count(1))
    return next(path for path in candidates if not path.with_suffix(".scenario.json").exists())
