"""Measures several robots under one router: ``python benchmarks/live_robots.py``.

Each robot has operator, filter, plant and recorder, all of them processes with keys of their own. In the second half of
the run a further operator of the first robot, whose keys let it in, publishes garbage. From the log of each robot: the
share of its ticks that each loop kept before and during that, and the verdict of its review.
"""

import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from multiprocessing import get_context
from multiprocessing.synchronize import Event
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Final

import numpy as np
import typer
from passafe_protocol.messages import FilterTick, OperatorCommand, PlantState
from passafe_protocol.topics import COMMAND, STATE, TICK
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.loop.bus import Bus, open_bus
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from report import AsJson, Report, Smallest

SCENARIO: Final = "walls-and-disks"
LOOPS: Final[dict[str, type[OperatorCommand | FilterTick | PlantState]]] = {
    "operator": OperatorCommand,
    "filter": FilterTick,
    "plant": PlantState,
}
BURST_S: Final = 0.01
PATIENCE_S: Final = 300.0
"""Longest wait: four processes of each robot start on the same processors."""

SETTLE_S: Final = 2.0
NS_PER_S: Final = 1e9

Span = tuple[float, float]
"""Begin and end of a stretch of time, monotonic, s."""


def flood(keys: Path, port: int, robot: str, each_hz: float, seconds: float, begun: Event) -> None:
    """Publish garbage as a further operator of a robot."""
    endpoint = RouterEndpoint(port=port, credentials=load_credentials(keys, "operator", robot))
    with open_bus(endpoint, robot=robot) as bus:
        put = bus.publisher(COMMAND, "operator")
        begun.set()
        due_s = time.monotonic()
        end_s = due_s + seconds
        while time.monotonic() < end_s:
            for _ in range(round(each_hz * BURST_S)):
                put(b"x" * 200)
            due_s += BURST_S
            time.sleep(max(0.0, due_s - time.monotonic()))


class Processes:
    """Processes of a deployment, which are stopped in reverse order.

    Args:
        keys: Folder of the deployment's keys.
        scenario: Scenario file of every robot.
        port: Port of the router.
    """

    def __init__(self, keys: Path, scenario: Path, port: int) -> None:
        self._options = ["--keys", str(keys), "--router", f"127.0.0.1:{port}"]
        self._scenario = ["--scenario", str(scenario)]
        self._started: list[subprocess.Popen[bytes]] = []

    def start(self, process: str, *options: str) -> None:
        """Start a process."""
        command = [sys.executable, "-P", "-m", "passafe_services.cli.run", process, *self._options, *options]
        if process != "router":
            command += self._scenario
        self._started.append(subprocess.Popen(command, stdout=subprocess.DEVNULL))  # noqa: S603 - ours

    def stop(self) -> None:
        """Stop every process; one that does not end is killed."""
        for process in reversed(self._started):
            process.send_signal(signal.SIGINT)
            try:
                process.wait(30.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


@contextmanager
def running(folder: Path, robots: list[str], rate_hz: float) -> Iterator[int]:
    """Run the robots, each with a log of its name; yield the router's port."""
    Deployment.create(folder / "keys").issue(identities_of(robots))
    scenario = folder / "scenario.json"
    scenario.write_text(load_scenario(SCENARIO, {"rate_hz": rate_hz}).model_dump_json(), encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = int(server.getsockname()[1])
    processes = Processes(folder / "keys", scenario, port)
    try:
        processes.start("router")
        with watcher(folder / "keys", port, robots[0]):
            pass  # the router listens
        for process in ("recorder", "operator", "filter", "plant"):
            for robot in robots:
                out = ["--out", str(folder / f"{robot}.mcap")] if process == "recorder" else []
                processes.start(process, "--robot", robot, *out)
        wait_for_loops(folder / "keys", port, robots)
        yield port
    finally:
        processes.stop()


def watcher(keys: Path, port: int, robot: str) -> AbstractContextManager[Bus]:
    """Return a session of one that may read what a robot's processes send."""
    endpoint = RouterEndpoint(port=port, credentials=load_credentials(keys, "dashboard", robot))
    return open_bus(endpoint, robot=robot, timeout_s=PATIENCE_S)


def wait_for_loops(keys: Path, port: int, robots: list[str]) -> None:
    """Wait until every loop of every robot has sent something.

    Raises:
        TimeoutError: One is not in time.
    """
    end_s = time.monotonic() + PATIENCE_S
    for robot in robots:
        with watcher(keys, port, robot) as bus:
            silent = [bus.reader(topic) for topic in (COMMAND, TICK, STATE)]
            while silent := [reader for reader in silent if not reader.drain()]:
                if time.monotonic() > end_s:
                    raise TimeoutError(robot)
                time.sleep(0.05)


def measured(keys: Path, port: int, robot: str, each_hz: float, seconds: float) -> tuple[Span, Span]:
    """Return a stretch without a flood, and one while a robot has one."""
    begin_s = time.monotonic()
    time.sleep(seconds)
    before = (begin_s, time.monotonic())
    context = get_context("spawn")
    begun = context.Event()
    stranger = context.Process(target=flood, args=(keys, port, robot, each_hz, seconds, begun))
    stranger.start()
    begun.wait(PATIENCE_S)
    begin_s = time.monotonic()
    stranger.join()
    return before, (begin_s, begin_s + seconds)


def kept(log: RunLog, loop: str, span: Span, rate_hz: float) -> float:
    """Return the share of its steps that a loop of a robot took in a stretch of time."""
    sent_s = np.array([message.header.sent_ns for message in log.of(LOOPS[loop])]) / NS_PER_S
    return float(np.sum((span[0] <= sent_s) & (sent_s < span[1])) / (rate_hz * (span[1] - span[0])))


def main(
    robots: Annotated[int, typer.Option(min=2, max=20, help="Number of robots.")] = 5,
    seconds: Annotated[float, typer.Option(min=1.0, help="Length of the stretches without and with the flood.")] = 15.0,
    rate_hz: Annotated[float, typer.Option("--rate", help="Rate of the loops.")] = 200.0,
    each_hz: Annotated[float, typer.Option("--each", help="Messages a second of the flood.")] = 20_000.0,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Report the share of ticks that the loops of each robot kept, and the verdicts."""
    if smallest:
        robots, seconds, rate_hz, each_hz = 2, 2.0, 120.0, 500.0
    names = [f"robot-{number + 1}" for number in range(robots)]
    with TemporaryDirectory() as made:
        folder = Path(made)
        with running(folder, names, rate_hz) as port:
            time.sleep(SETTLE_S)
            before, flooded = measured(folder / "keys", port, names[0], each_hz, seconds)
        logs = {name: RunLog.read(folder / f"{name}.mcap") for name in names}
    columns = [f"{loop} {when}" for loop in LOOPS for when in ("before", "flooded")]
    report = Report(
        title=f"{robots} robots at {rate_hz:g} Hz, {each_hz:,.0f} garbage messages a second to {names[0]}",
        columns=(
            "robot",
            *columns,
            "lowest h",
            "verdict",
        ),
    )
    for name, log in logs.items():
        verdict = Verdict.of(log, CoreEvaluator(log.identity.scenario))
        shares = [kept(log, loop, span, rate_hz) for loop in LOOPS for span in (before, flooded)]
        if verdict.h_min is None or verdict.h_min < 0.0:
            report.failures.append(f"{name}: lowest h {verdict.h_min}, allowed ≥ 0")
        lowest = "–" if verdict.h_min is None else f"{verdict.h_min:.2g}"
        report.rows.append((name, *(f"{share:.2%}" for share in shares), lowest, verdict.words))
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
