"""The supervisor and real processes."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from passafe_services.loop.child_process import ChildProcess
from passafe_services.loop.process_exit import ExitCause
from passafe_services.loop.process_spec import ProcessSpec, RestartPolicy
from passafe_services.loop.supervisor import supervise

pytestmark = pytest.mark.live

TOY = str(Path(__file__).with_name("toy_process.py"))
PATIENCE_S = 20.0


def toy(
    name: str, kind: str = "plain", *arguments: object, grace_s: float = 10.0, restarts: RestartPolicy | None = None
) -> ProcessSpec:
    argv = (sys.executable, TOY, kind, "--name", name, *map(str, arguments))
    return ProcessSpec(name=name, argv=argv, grace_s=grace_s, restarts=restarts)


class Terminal:
    """Output of a supervisor with times, and the pids that the toys print."""

    def __init__(self) -> None:
        self.lines: list[tuple[float, str]] = []
        self.pids: dict[str, dict[str, int]] = {}
        self.said_pid: list[tuple[str, int]] = []
        self.on_pid: Callable[[str, int], None] = lambda _name, _pid: None

    def __call__(self, line: str) -> None:
        """Take a line."""
        self.lines.append((time.monotonic(), line))
        name, bar, text = line.partition(" | ")
        if bar and text.startswith("{"):
            output = json.loads(text)
            if "pid" in output:
                self.pids[name.strip()] = output
                self.said_pid.append((name.strip(), output["pid"]))
                self.on_pid(name.strip(), output["pid"])

    def when(self, text: str) -> float:
        """Return the time of the first line with ``text``."""
        return next(at for at, line in self.lines if text in line)

    @property
    def texts(self) -> list[str]:
        """The lines without their times."""
        return [line for _, line in self.lines]

    @property
    def all_pids(self) -> list[int]:
        """Of all toys and what they started."""
        return [pid for output in self.pids.values() for pid in output.values()]


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"


def gone(pids: list[int]) -> bool:
    """Wait until all of them have ended; return false after a timeout."""
    end = time.monotonic() + PATIENCE_S
    while any(alive(pid) for pid in pids):
        if time.monotonic() > end:
            return False
        time.sleep(0.01)
    return True


@pytest.fixture
def terminal() -> Terminal:
    return Terminal()


def test_processes_start_in_order_and_stop_in_the_opposite_order(terminal: Terminal) -> None:
    sessions = {}

    def look() -> None:
        terminal("all are ready")
        sessions.update({output["pid"]: os.getsid(output["pid"]) for output in terminal.pids.values()})

    specs = [toy("first"), toy("second"), toy("third")]
    outcome = supervise(specs, duration_s=0.0, emit=terminal, on_ready=look)
    assert outcome.cause is ExitCause.DURATION
    assert outcome.clean
    assert [end.name for end in outcome.exits] == ["third", "second", "first"]
    assert list(terminal.pids) == ["first", "second", "third"]
    assert len(sessions) == 3
    assert 'first  | {"stopped": "first"}' in terminal.texts
    assert "second | to standard error" in terminal.texts
    assert all(pid == session for pid, session in sessions.items())  # out of reach of a terminal's Ctrl-C
    assert not any("passafe-ready" in line for line in terminal.texts)
    assert gone(terminal.all_pids)


def test_killed_process_is_named_and_nothing_is_left(terminal: Terminal) -> None:
    killed_at = []

    def kill() -> None:
        killed_at.append(time.monotonic())
        os.kill(terminal.pids["plant"]["pid"], signal.SIGKILL)

    outcome = supervise([toy("router"), toy("plant"), toy("filter")], emit=terminal, on_ready=kill)
    assert outcome.cause is ExitCause.DIED
    assert outcome.culprit == "plant"
    assert outcome.detail == "plant died: killed by SIGKILL"
    assert [end.name for end in outcome.died] == ["plant"]
    assert [(end.name, end.returncode) for end in outcome.exits] == [
        ("plant", -9),
        ("filter", 0),
        ("router", 0),
    ]
    assert not outcome.clean
    assert terminal.when("plant died") - killed_at[0] < 1.0
    assert gone(terminal.all_pids)


def test_a_process_that_fails_is_named_with_its_exit_code(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("filter", "brief", "--code", 3)], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.DIED, "filter")
    assert outcome.detail == "filter died: exit code 3"
    assert gone(terminal.all_pids)


def test_a_process_that_leaves_ends_the_run_cleanly(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("operator", "brief")], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.LEFT, "operator")
    assert outcome.clean
    assert outcome.died == ()


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_one_signal_stops_all_cleanly(terminal: Terminal, signum: int) -> None:
    outcome = supervise([toy("plant"), toy("filter")], emit=terminal, on_ready=lambda: os.kill(os.getpid(), signum))
    assert outcome.cause is ExitCause.SIGNAL
    assert outcome.detail == f"stopped by {signal.Signals(signum).name}"
    assert outcome.clean
    assert gone(terminal.all_pids)


def test_a_second_signal_kills_at_once(terminal: Terminal) -> None:
    def interrupt_twice() -> None:
        os.kill(os.getpid(), signal.SIGINT)
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()

    began = time.monotonic()
    outcome = supervise(
        [toy("plant"), toy("filter", "stubborn", grace_s=60.0)], emit=terminal, on_ready=interrupt_twice
    )
    assert time.monotonic() - began < PATIENCE_S
    assert outcome.cause is ExitCause.SIGNAL
    assert all(end.killed and end.returncode == -signal.SIGKILL for end in outcome.exits)
    assert gone(terminal.all_pids)


def test_process_ignoring_sigterm_is_killed_with_its_children(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("filter", "stubborn", grace_s=0.2)], duration_s=0.0, emit=terminal)
    assert outcome.cause is ExitCause.DURATION
    assert not outcome.clean
    assert [(end.name, end.killed) for end in outcome.exits] == [("filter", True), ("plant", False)]
    assert "filter was killed: it did not end in 0.2 s" in terminal.texts
    assert set(terminal.pids["filter"]) == {"pid", "child"}
    assert gone(terminal.all_pids)


def test_what_a_killed_process_started_does_not_stay_behind(terminal: Terminal) -> None:
    outcome = supervise(
        [toy("filter", "stubborn")],
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.detail == "filter died: killed by SIGKILL"
    assert gone(terminal.all_pids)


def test_dead_process_is_restarted_while_the_others_run_on(terminal: Terminal) -> None:
    def stop_when_back(name: str, _pid: int) -> None:
        if [output for output, _ in terminal.said_pid].count(name) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    terminal.on_pid = stop_when_back
    outcome = supervise(
        [toy("router"), toy("filter", restarts=RestartPolicy()), toy("plant")],
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.cause is ExitCause.SIGNAL
    assert outcome.restarts == {"filter": 1}
    assert terminal.texts.count("filter died: killed by SIGKILL; restarted") == 1
    assert [name for name, _ in terminal.said_pid] == ["router", "filter", "plant", "filter"]
    assert [end.name for end in outcome.exits] == ["filter", "plant", "filter", "router"]  # in its old place
    assert gone([pid for _, pid in terminal.said_pid])


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root may raise priorities")
def test_one_that_is_started_is_preferred_until_it_is_ready(terminal: Terminal) -> None:
    """The toy says its pid before it is ready."""
    own = os.getpriority(os.PRIO_PROCESS, 0)
    preferred: list[bool] = []

    def look(_name: str, pid: int) -> None:
        preferred.append(os.getpriority(os.PRIO_PROCESS, pid) < own)
        if len(preferred) == 2:
            threading.Thread(target=stop_when_ordinary, args=(pid,)).start()

    def stop_when_ordinary(pid: int) -> None:
        end = time.monotonic() + PATIENCE_S
        while os.getpriority(os.PRIO_PROCESS, pid) != own and time.monotonic() < end:
            time.sleep(0.01)
        preferred.append(os.getpriority(os.PRIO_PROCESS, pid) < own)
        os.kill(os.getpid(), signal.SIGINT)

    terminal.on_pid = look
    supervise(
        [toy("filter", restarts=RestartPolicy())],
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert preferred == [True, True, False]


def test_one_that_dies_too_often_ends_the_run(terminal: Terminal) -> None:
    def kill(name: str, pid: int) -> None:
        if name == "filter" and terminal.texts.count("all are ready"):
            os.kill(pid, signal.SIGKILL)

    def begin() -> None:
        terminal("all are ready")
        kill("filter", terminal.pids["filter"]["pid"])

    terminal.on_pid = kill
    filter_spec = toy("filter", restarts=RestartPolicy(most=2, within_s=600.0))
    outcome = supervise([toy("plant"), filter_spec], emit=terminal, on_ready=begin)
    assert (outcome.cause, outcome.culprit) == (ExitCause.DIED, "filter")
    assert outcome.detail == "filter died: killed by SIGKILL"
    assert outcome.restarts == {"filter": 2}
    assert not outcome.clean
    assert gone([pid for _, pid in terminal.said_pid])


def test_deaths_long_ago_do_not_count(terminal: Terminal) -> None:
    """With a stretch of no length none ever does, so the fourth death is like the first."""

    def kill(_name: str, pid: int) -> None:
        if len(terminal.said_pid) <= 4:
            os.kill(pid, signal.SIGKILL)
        else:
            os.kill(os.getpid(), signal.SIGTERM)

    def begin() -> None:
        kill(*terminal.said_pid[0])
        terminal.on_pid = kill

    outcome = supervise([toy("filter", restarts=RestartPolicy(most=1, within_s=0.0))], emit=terminal, on_ready=begin)
    assert outcome.cause is ExitCause.SIGNAL
    assert outcome.restarts == {"filter": 4}


def test_a_process_that_leaves_is_not_started_again(terminal: Terminal) -> None:
    outcome = supervise([toy("plant"), toy("operator", "brief", restarts=RestartPolicy())], emit=terminal)
    assert (outcome.cause, outcome.culprit) == (ExitCause.LEFT, "operator")
    assert outcome.restarts == {}


def test_death_that_ends_the_run_is_not_masked_by_a_restart(terminal: Terminal) -> None:
    def kill() -> None:
        for name in ("filter", "plant"):
            os.kill(terminal.pids[name]["pid"], signal.SIGKILL)
        time.sleep(0.2)  # holds up the supervisor itself, so that it finds both ends at once

    outcome = supervise([toy("filter", restarts=RestartPolicy()), toy("plant")], emit=terminal, on_ready=kill)
    assert (outcome.cause, outcome.culprit) == (ExitCause.DIED, "plant")
    assert gone(terminal.all_pids)


def test_duration_includes_the_time_of_restarts(terminal: Terminal) -> None:
    outcome = supervise(
        [toy("filter", restarts=RestartPolicy())],
        duration_s=3.0,
        emit=terminal,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.cause is ExitCause.DURATION
    assert outcome.restarts == {"filter": 1}
    assert outcome.clean
    assert gone([pid for _, pid in terminal.said_pid])


def test_restarted_process_that_is_not_ready_is_killed_and_named(terminal: Terminal, tmp_path: Path) -> None:
    """The toy is ready the first time only: later it finds its mark."""
    code = (
        "import json, os, pathlib, sys, time; from passafe_services.loop.readiness import announce_ready; "
        "mark = pathlib.Path(sys.argv[1]); again = mark.exists(); mark.touch(); "
        "again or print(json.dumps({'pid': os.getpid()}), flush=True); again or announce_ready('filter'); "
        "time.sleep(60)"
    )
    spec = ProcessSpec(
        name="filter",
        argv=(sys.executable, "-c", code, str(tmp_path / "mark")),
        restarts=RestartPolicy(most=2, within_s=600.0),
    )
    outcome = supervise(
        [spec],
        emit=terminal,
        ready_timeout_s=5.0,
        on_ready=lambda: os.kill(terminal.pids["filter"]["pid"], signal.SIGKILL),
    )
    assert outcome.cause is ExitCause.DIED
    assert outcome.restarts == {"filter": 2}
    assert terminal.texts[1:] == [
        "filter died: killed by SIGKILL; restarted",
        "filter was not ready within 5 s: killed",
        "filter died: killed by SIGKILL; restarted",
        "filter was not ready within 5 s: killed",
        "filter died: killed by SIGKILL",
    ]


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
