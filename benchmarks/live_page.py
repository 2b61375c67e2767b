"""Measures what pages cost, and how fast they drive: ``python benchmarks/live_page.py``.

One demo runs with a page that drives all the time, 60 commands a second, each in the other direction than the one
before. By turns nobody and ten pages watch; ``--pages 1``: one. From the log: lateness and missed ticks of the filter's
loop with and without them, and the time from the send of a command in the page's client to the first of the operator
that follows it.
"""

import json
import multiprocessing
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.synchronize import Event
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Final

import numpy as np
import typer
from passafe_protocol.messages import FilterTick, OperatorCommand
from passafe_services.tools.review.run_log import RunLog
from report import AsJson, Ratio, Report, Smallest
from timing import Times
from websockets.sync.client import connect

PAGES: Final = 10
STEER_S: Final = 1 / 60
RELEASE: Final = 30
"""Every so many commands the dead-man is let go: after a stall the page drives again."""


Span = tuple[int, int]
"""Begin and end of a stretch of time, monotonic, ns."""


def watch(host: str, count: int, wanted: Event, ended: Event) -> None:
    """Be pages that watch whenever wanted."""
    while not ended.is_set():
        if not wanted.wait(0.1):
            continue
        with ExitStack() as stack:
            pages = [stack.enter_context(connect(f"ws://{host}/live", compression=None)) for _ in range(count)]
            while wanted.is_set() and not ended.is_set():
                for page in pages:
                    page.recv(timeout=10.0)


class Driver:
    """Page that drives: the times at which it sent commands, and their signs."""

    def __init__(self, host: str) -> None:
        self.sent: list[tuple[int, float]] = []
        self._page = connect(f"ws://{host}/drive", compression=None, legacy=True)
        self._clock_ms, self._arrived_s = 0.0, 0.0

    def drive(self, until_s: float) -> None:
        """Send commands until a monotonic time, and take the wheel whenever another has it."""
        due_s = time.monotonic()
        while due_s < until_s:
            self._read(due_s)
            sign = 1.0 if len(self.sent) % 2 else -1.0
            held_ms = (time.monotonic() - self._arrived_s) * 1e3
            engaged = len(self.sent) % RELEASE != 0
            steer = {"number": len(self.sent), "shares": [sign * 0.3, 0.0], "engaged": engaged}
            self.sent.append((time.monotonic_ns(), sign if engaged else 0.0))
            self._send("steer", **steer, echo_ms=self._clock_ms, held_ms=held_ms)
            due_s = max(due_s + STEER_S, time.monotonic())  # a browser that was held up sends no more for it

    def wait_for_clock(self) -> None:
        """Take the wheel and wait for a clock message."""
        self._send("take", over=True)
        while not self._clock_ms:
            self._read(time.monotonic() + 0.1)

    def close(self) -> None:
        """Leave."""
        self._page.close()

    def _send(self, kind: str, **fields: object) -> None:
        self._page.send(json.dumps({"type": kind} | fields))

    def _read(self, until_s: float) -> None:
        while True:
            try:
                message = json.loads(self._page.recv(timeout=max(until_s - time.monotonic(), 0.0)))
            except TimeoutError:
                return
            if message["type"] == "clock":
                self._clock_ms, self._arrived_s = message["server_ms"], time.monotonic()
            elif message["type"] == "driver" and not message["you"] and message["reason"]:
                self._send("take", over=True)


def free_port() -> int:
    """Return a port on which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


@contextmanager
def demo(folder: Path, scenario: str, rate_hz: float, seconds: float) -> Iterator[str]:
    """Run a demo; yield where its page is, and wait for its end."""
    port = free_port()
    command = [sys.executable, "-P", "-m", "passafe_services.cli", "demo", "--scenario", scenario]
    command += ["--rate", str(rate_hz), "--duration", str(seconds), "--out", str(folder), "--port", str(port)]
    command += ["--router-port", str(free_port())]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603 - ours
        try:
            lines = iter(process.stdout or ())
            next(line for line in lines if line.startswith("running"))
            yield f"127.0.0.1:{port}"
            for _ in lines:
                pass
        finally:
            process.terminate()


def measure(
    folder: Path, scenario: str, rate_hz: float, rounds: int, span_s: float, pages: int
) -> tuple[list[Span], list[Span], Driver]:
    """Return the stretches without and with pages, and who drove."""
    context = multiprocessing.get_context("spawn")
    wanted, ended = context.Event(), context.Event()
    alone: list[Span] = []
    watched: list[Span] = []
    with demo(folder, scenario, rate_hz, rounds * 2 * span_s + 20.0) as host:
        watcher = context.Process(target=watch, args=(host, pages, wanted, ended))
        watcher.start()
        driver = Driver(host)
        driver.wait_for_clock()
        driver.drive(time.monotonic() + 2.0)
        for spans in (alone, watched) * rounds:
            wanted.set() if spans is watched else wanted.clear()
            begun_ns = time.monotonic_ns()
            driver.drive(time.monotonic() + span_s)
            spans.append((begun_ns, time.monotonic_ns()))
        ended.set()
        driver.close()
        watcher.join()
    return alone, watched, driver


def loop_of(log: RunLog, span: Span, period_ns: float) -> tuple[Times, int]:
    """Return the lateness of the filter's ticks in a stretch, µs, and how many were missed."""
    heads = [tick.header for tick in log.of(FilterTick) if span[0] <= tick.header.scheduled_ns < span[1]]
    due_ns = np.array([head.scheduled_ns for head in heads])
    late_us = np.array([head.started_ns for head in heads]) - due_ns
    return late_us / 1e3, int(np.sum(np.round(np.diff(np.unique(due_ns)) / period_ns) - 1))


def ways_ms(log: RunLog, driver: Driver, spans: list[Span]) -> Times:
    """Return the times from the send of a command to the operator's first command that follows it, ms."""
    commands = [each for each in log.of(OperatorCommand) if each.body.device == "page" and each.body.enabled]
    sent_ns = np.array([each.header.sent_ns for each in commands])
    signs = np.sign([each.body.u_h_rate[0] for each in commands])
    found = []
    for (at_ns, sign), (next_ns, _) in zip(driver.sent, driver.sent[1:], strict=False):
        if not sign or not any(begin <= at_ns < end for begin, end in spans):
            continue
        after = np.searchsorted(sent_ns, at_ns)
        follows = np.flatnonzero(signs[after:] == sign)
        if follows.size and sent_ns[after + follows[0]] < next_ns + 250_000_000:
            found.append((sent_ns[after + follows[0]] - at_ns) / 1e6)
    return np.array(found)


def main(
    rate: Annotated[float, typer.Option(min=10.0, help="Ticks a second.")] = 500.0,
    rounds: Annotated[int, typer.Option(min=1, help="Stretches without and with pages.")] = 4,
    pages: Annotated[int, typer.Option(min=1, max=30, help="Pages that watch.")] = PAGES,
    scenario: Annotated[str, typer.Option(help="Scenario that is driven.")] = "walls-and-disks",
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Report lateness and missed ticks without and with pages, and the time from page to operator."""
    span_s = 5.0
    if smallest:
        rate, rounds, span_s = 200.0, 1, 1.0
    with TemporaryDirectory() as folder:
        alone, watched, driver = measure(Path(folder), scenario, rate, rounds, span_s, pages)
        [path] = Path(folder).glob("*.mcap")
        log = RunLog.read(path)
    report = Report(
        title=f"Pages, {rounds} × {span_s:g} s each at {rate:g} Hz", columns=("what", "p50", "p99", "most", "missed")
    )
    medians = []
    for name, spans in (
        ("nobody watches", alone),
        (f"{pages} {'page watches' if pages == 1 else 'pages watch'}", watched),
    ):
        loops = [loop_of(log, span, 1e9 / rate) for span in spans]
        medians.append([float(np.median(late_us)) for late_us, _ in loops])
        late_us, missed = np.concatenate([each for each, _ in loops]), sum(count for _, count in loops)
        p50, p99 = np.percentile(late_us, [50, 99])
        row = (f"lateness of the filter, {name}", f"{p50:.0f} µs", f"{p99:.0f} µs", f"{late_us.max():.0f} µs")
        report.rows.append((*row, f"{missed} of {late_us.size + missed}"))
        ways = ways_ms(log, driver, spans)
        if not ways.size:
            report.failures.append(f"{name}: no command of the page reached the operator")
            continue
        p50, p99 = np.percentile(ways, [50, 99])
        row = (f"page to operator, {name} ({ways.size})", f"{p50:.1f} ms", f"{p99:.1f} ms", f"{ways.max():.1f} ms")
        report.rows.append((*row, ""))
    many = "ten" if pages == PAGES else str(pages)
    of, over = f"median lateness of the filter's loop beside {many} pages", "beside none"
    report.ratios.append(Ratio.of_rounds(of, medians[1], over, medians[0]))
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
