"""Measures the loops of a live system under a flood of garbage: ``python benchmarks/live_flood.py``.

A stranger on the bus of an insecure ``passafe demo`` publishes random bytes under every key of the topic table, 20,000
a second on every topic. The last ``Health`` of each process says which share of its ticks it kept.
"""

import json
import multiprocessing
import random
import socket
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer
import zenoh
from passafe_protocol.messages import Health
from passafe_protocol.topics import TOPICS
from passafe_services.tools.review.run_log import RunLog
from report import AsJson, Report, Smallest

LOOPS = ("operator", "filter", "plant")
TURN_S = 0.01
FLOOD_SHARE = 0.6
"""Share of the run for which the flood lasts, in its middle."""


def flood(port: int, each_hz: float, seconds: float, sent: "multiprocessing.Queue[float]") -> None:
    """Publish garbage under the first publisher's key of every topic, in turns, and say how much a second."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("connect/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    generator = random.Random(1)  # noqa: S311 - no secret
    garbage = [generator.randbytes(size) for size in (0, 7, 60, 150, 400)]
    with zenoh.open(config) as session:
        publishers = [session.declare_publisher(topic.key(topic.publishers[0])) for topic in TOPICS]
        started = due = time.monotonic()
        count = 0
        while time.monotonic() < started + seconds:
            for publisher in publishers:
                for k in range(round(each_hz * TURN_S)):
                    publisher.put(garbage[k % len(garbage)])
                    count += 1
            due += TURN_S
            time.sleep(max(0.0, due - time.monotonic()))
        sent.put(count / (time.monotonic() - started))


def free_port() -> int:
    """Return a port on which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def flooded_run(seconds: float, each_hz: float, rate_hz: float, folder: Path) -> tuple[RunLog, float]:
    """Run a demo under a flood and return its log and the messages that the stranger sent, 1/s."""
    port, sent = free_port(), multiprocessing.get_context("spawn").Queue()
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--headless", "--insecure"]
    options = {"--duration": seconds, "--rate": rate_hz, "--out": folder, "--router-port": port}
    arguments = [str(part) for pair in options.items() for part in pair]
    demo = subprocess.Popen([*command, *arguments], stdout=subprocess.DEVNULL)  # noqa: S603 - ours
    stranger = multiprocessing.get_context("spawn").Process(
        target=flood, args=(port, each_hz, FLOOD_SHARE * seconds, sent)
    )
    while not list(folder.glob("*.mcap")) and demo.poll() is None:
        time.sleep(0.05)
    time.sleep(0.2 * seconds)
    stranger.start()
    demo.wait()
    rate = sent.get(timeout=10.0)
    stranger.join()
    [log] = folder.glob("*.mcap")
    return RunLog.read(log), rate


def main(
    seconds: Annotated[float, typer.Option(min=2.0, help="Length of the run.")] = 15.0,
    each_hz: Annotated[float, typer.Option("--each", help="Messages a second on every topic.")] = 20_000.0,
    rate_hz: Annotated[float, typer.Option("--rate", help="Rate of the loops.")] = 200.0,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Report the share of ticks that each loop kept, and what it refused."""
    if smallest:
        seconds, each_hz = 3.0, 500.0
    with TemporaryDirectory() as folder:
        log, sent_hz = flooded_run(seconds, each_hz, rate_hz, Path(folder))
    report = Report(
        title=f"{sent_hz:,.0f} garbage messages a second on {len(TOPICS)} topics, loops at {rate_hz:g} Hz",
        columns=("process", "ticks kept", "messages refused"),
    )
    for process in LOOPS:
        last = [each.body for each in log.of(Health) if each.header.source == process][-1]
        kept = last.steps / max(1, last.steps + last.steps_skipped)
        refused = sum(topic.refused for topic in last.topics)
        report.rows.append((process, f"{kept:.2%}", f"{refused:,}"))
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
