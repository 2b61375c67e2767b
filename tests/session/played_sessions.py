"""Sessions played to their end, and their processes."""

import os
import signal
from collections.abc import Callable

from passafe_services.loop.process_exit import RunOutcome
from passafe_services.loop.supervision import Supervision
from passafe_services.loop.supervisor import supervised
from toy_runs import Script


def play(script: Script) -> tuple[RunOutcome, list[str]]:
    """Run a session to its end; return it with the lines that were printed."""
    lines: list[str] = []

    async def run(supervision: Supervision) -> RunOutcome:
        end = await script.session.run(supervision)
        await supervision.stop()
        return RunOutcome(cause=end.cause, culprit=end.culprit, detail=end.detail, exits=supervision.take_exits())

    return supervised(run, emit=lines.append, on_change=script.session.on_change), lines


def when(condition: Callable[[], bool], act: Callable[[], object]) -> Callable[[], None]:
    """Return a listener that acts once, at the first change after which the condition holds."""
    acted: list[bool] = []

    def listen() -> None:
        if not acted and condition():
            acted.append(True)
            act()

    return listen


def pid_of(script: Script, name: str) -> int:
    """Return the process id of a process, 0 while there is none."""
    supervision = script.session._supervision
    child = None if supervision is None else supervision._child(name)
    return 0 if child is None or child._transport is None else child._transport.get_pid()


def kill_named(script: Script, name: str) -> None:
    os.kill(pid_of(script, name), signal.SIGKILL)
