"""A session of runs: router and page stay, while runs begin, end and change on request."""

from collections.abc import Callable, Sequence
from typing import Final, Literal, Protocol

from passafe_services.loop.process_exit import ExitCause, RunEnd, RunOutcome
from passafe_services.loop.process_name import ProcessName
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.supervision import Supervision
from passafe_services.session.control_messages import EndedRun, ProcessView, SessionState
from passafe_services.session.planned_run import PlannedRun

Phase = Literal["starting", "running", "stopping", "stopped"]

Conclude = Callable[[str, str], None]
"""Takes the outcome of a run and its verdict in words; to be called in the thread of the session."""

_CANNOT_START: Final = (ExitCause.NOT_READY, ExitCause.NOT_STARTED, ExitCause.DIED, ExitCause.LEFT)


class RunReports(Protocol):
    """Reports of the runs of a session."""

    def ready(self, number: int, run: PlannedRun) -> None:
        """Report a run whose processes are ready."""

    def ended(self, number: int, run: PlannedRun, outcome: RunOutcome, conclude: Conclude, *, began: bool) -> None:
        """Report a run that has ended, its log closed; in one that never began there is nothing to judge."""


class RunSession:
    """Runs of one demo, one after the other.

    A run has one scenario, one mode and one log: a change of these ends it and begins the next.

    Attributes:
        phase: Of the present run.
        number: Number of the present run, or of the last one; the first has 1.
        present: The present run, or the last one.
        wanted: Run that follows the present one, if one was requested.

    Args:
        base: Processes that all runs share.
        first: The first run.
        reports: Where runs are reported.
        scenarios: Scenarios that may be requested.
    """

    def __init__(
        self, base: Sequence[ProcessSpec], first: PlannedRun, *, reports: RunReports, scenarios: Sequence[str]
    ) -> None:
        self.phase: Phase = "starting"
        self.number = 0
        self.present = first
        self.wanted: PlannedRun | None = None
        self.on_change: Callable[[], None] = lambda: None
        self._base = tuple(base)
        self._reports = reports
        self._scenarios = tuple(scenarios)
        self._last: EndedRun | None = None
        self._trouble = ""
        self._supervision: Supervision | None = None

    async def run(self, supervision: Supervision) -> RunEnd:
        """Run one run after the other; return the end of the last one.

        A run that is ended on request, or that was requested and cannot be started, leaves the session waiting for the
        next request; any other end is that of the session.
        """
        self._supervision = supervision
        end = await supervision.start(self._base)
        if end is not None:
            return end
        next_run: PlannedRun | None = self.present
        while True:
            if next_run is None:
                self._enter("stopped")
                end, goes_on = await supervision.watch(), False
            else:
                end, goes_on = await self._one_run(supervision, next_run)
            if supervision.end_requests.stop.is_set() or not (goes_on or end.cause is ExitCause.REQUESTED):
                self._drop_wanted()
                return end
            supervision.end_requests.interrupt.clear()
            next_run, self.wanted = self.wanted, None

    def start(self, run: PlannedRun) -> None:
        """Let a run follow the present one, which ends."""
        self._drop_wanted()
        self.wanted = run
        self._interrupt()

    def end(self) -> bool:
        """End the present run; return whether there is one."""
        if self.phase == "stopped":
            return False
        self._drop_wanted()
        self._interrupt()
        return True

    def kill(self, name: ProcessName) -> bool:
        """Kill a process; return whether it ran. It stays down until a restart unless a restart policy says else."""
        return self._supervision is not None and self._supervision.kill(name)

    def restart(self, name: ProcessName, *options: str) -> bool:
        """Start a process anew; return whether there is one."""
        return self._supervision is not None and self._supervision.restart(name, *options)

    def permitted(self, name: str) -> tuple[str, ...]:
        """Return what may be requested of a process now: kill, restart, or nothing."""
        states = {} if self._supervision is None else self._supervision.states
        if self.phase not in {"running", "stopped"} or name not in states or name not in {*ProcessName}:
            return ()
        if name == ProcessName.DASHBOARD:  # it could not answer the request
            return ()
        restart = () if name == ProcessName.RECORDER else ("restart",)  # its log would be in two parts
        return (*(() if states[name] == "down" else ("kill",)), *restart)

    @property
    def state(self) -> SessionState:
        """State as the page shows it."""
        run, processes = self.present, {} if self._supervision is None else self._supervision.states
        recorder = processes.get(ProcessName.RECORDER, "down")
        return SessionState(
            state=self.phase,
            run=self.number,
            scenario=run.choices.scenario,
            mode=run.scenario.filter.mode,
            prediction=run.scenario.filter.prediction,
            gatekeeper=run.scenario.filter.gatekeeper,
            rate_hz=run.scenario.rate_hz,
            recording=run.log is not None and recorder != "down",
            log=None if run.log is None else run.log.name,
            can=("run", "mode", "prediction", "gatekeeper", "rate", "recording", "processes"),
            scenarios=self._scenarios,
            processes={name: ProcessView(state=now, can=self.permitted(name)) for name, now in processes.items()},
            last=self._last,
            trouble=self._trouble,
        )

    def _interrupt(self) -> None:
        if self._supervision is not None and self.phase != "stopping":
            self._supervision.end_requests.interrupt.set()
        self.on_change()

    def _drop_wanted(self) -> None:
        if self.wanted is not None:
            self.wanted.discard()
            self.wanted = None

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        self.on_change()

    async def _one_run(self, supervision: Supervision, run: PlannedRun) -> tuple[RunEnd, bool]:
        """Run one run; return its end and whether the session goes on without it."""
        self.present, self._trouble = run, ""
        self.number += 1
        self._enter("starting")
        end = await supervision.start(run.specs)
        began = end is None
        if end is None:
            self._enter("running")
            self._reports.ready(self.number, run)
            end = await supervision.watch(run.most_s)
        self._enter("stopping")
        names = {spec.name for spec in run.specs}
        await supervision.stop(names)
        outcome = RunOutcome.of(end, supervision.take_exits())
        log = None if run.log is None else run.log.name
        self._last = EndedRun(run=self.number, log=log, detail=end.detail)
        self._reports.ended(self.number, run, outcome, self._conclusion(self.number), began=began)
        fails_to_start = not began and end.cause in _CANNOT_START and end.culprit in names
        if fails_to_start:
            self._trouble = end.detail
        return end, fails_to_start and self.number > 1

    def _conclusion(self, number: int) -> Conclude:
        def conclude(outcome: str, words: str) -> None:
            if self._last is not None and self._last.run == number:
                self._last = self._last.model_copy(update={"outcome": outcome, "words": words})
                self.on_change()

        return conclude
