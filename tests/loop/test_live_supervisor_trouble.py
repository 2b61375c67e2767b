"""Processes that do not start, do not become ready or say anything, and supervisors that end."""

import json
import os
import signal
import subprocess
import sys

import pytest
from passafe_services.loop.child_process import ChildProcess
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.supervisor import supervise
from supervised_toys import PATIENCE_S, TOY, Terminal, alive, gone, toy

pytestmark = pytest.mark.live


def test_a_process_that_is_not_ready_in_time_ends_the_run(terminal: Terminal) -> None:
    specs = [toy("plant"), toy("filter", "slow"), toy("operator")]
    outcome = supervise(specs, emit=terminal, ready_timeout_s=2.0)
    assert (outcome.cause, outcome.culprit) == (ExitCause.NOT_READY, "filter")
    assert outcome.detail == "filter was not ready within 2 s"
    assert {end.name for end in outcome.exits} == {"plant", "filter"}
    assert gone(terminal.all_pids)


def test_a_program_that_does_not_exist_ends_the_run(terminal: Terminal) -> None:
    missing = ProcessSpec(name="filter", argv=("/nonexistent/program",))
    outcome = supervise([toy("plant"), missing], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.NOT_STARTED, "filter")
    assert "filter cannot be started: " in terminal.texts[-2] + terminal.texts[-1]
    assert [end.name for end in outcome.exits] == ["plant"]
    assert gone(terminal.all_pids)


def test_an_exception_of_the_caller_leaves_nothing_behind(terminal: Terminal) -> None:
    def fail() -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        supervise([toy("plant"), toy("filter")], emit=terminal, on_ready=fail)
    assert gone(terminal.all_pids)


def test_lines_of_any_kind_and_length_are_relayed(terminal: Terminal) -> None:
    code = "import sys; sys.stdout.buffer.write(b'x' * 200_000 + b'\\n' + b'\\xff\\n' + b'no end')"
    outcome = supervise([ProcessSpec(name="talker", argv=(sys.executable, "-c", code))], emit=terminal)
    assert outcome.cause is ExitCause.LEFT
    relayed = [line.removeprefix("talker | ") for line in terminal.texts if line.startswith("talker | ")]
    assert sum(line.count("x") for line in relayed) == 200_000
    assert relayed[-2:] == ["\N{REPLACEMENT CHARACTER}", "no end"]


SUPERVISOR = """
import json, sys
from passafe_services.loop.process_spec import ProcessSpec
from passafe_services.loop.supervisor import supervise
specs = [ProcessSpec(name=name, argv=tuple(argv)) for name, argv in json.loads(sys.argv[1])]
supervise(specs, on_ready=lambda: print("all are ready", flush=True))
"""


def test_a_killed_supervisor_leaves_nothing_behind(terminal: Terminal) -> None:
    specs = json.dumps([(spec.name, spec.argv) for spec in (toy("plant"), toy("filter"))])
    with subprocess.Popen([sys.executable, "-c", SUPERVISOR, specs], stdout=subprocess.PIPE, text=True) as supervisor:
        while (line := supervisor.stdout.readline()) != "all are ready\n":
            assert line
            terminal(line)
        assert all(alive(pid) for pid in terminal.all_pids)
        assert len(terminal.all_pids) == 2
        os.kill(supervisor.pid, signal.SIGKILL)
        supervisor.wait(PATIENCE_S)
    assert gone(terminal.all_pids)


def test_a_live_system_is_stopped_in_order(terminal: Terminal, port: int) -> None:
    """Router and two loops at 1 kHz; the router stops last, so no process loses it."""

    def process(name: str, *arguments: object) -> ProcessSpec:
        argv = (sys.executable, TOY, name, "--port", port, "--lifeline", *arguments)
        return ProcessSpec(name=name, argv=tuple(map(str, argv)))

    outcome = supervise([process("router"), process("filter"), process("operator")], duration_s=0.5, emit=terminal)
    assert outcome.clean, terminal.texts
    assert [end.name for end in outcome.exits] == ["operator", "filter", "router"]
    assert sum('"reason": "SIGNAL"' in line for line in terminal.texts) == 3


@pytest.mark.parametrize("error", [RuntimeError("can't start new thread"), MemoryError(), OSError(24, "Too many")])
def test_lack_of_resources_is_one_line_and_no_traceback(error: Exception, monkeypatch: pytest.MonkeyPatch) -> None:
    async def fail(*_arguments: object, **_options: object) -> ChildProcess:
        raise error

    lines: list[str] = []
    monkeypatch.setattr(ChildProcess, "start", fail)
    outcome = supervise([toy("one")], emit=lines.append)

    assert outcome.cause is ExitCause.NOT_STARTED
    assert not outcome.clean
    assert lines == [f"one cannot be started: {error}"]
