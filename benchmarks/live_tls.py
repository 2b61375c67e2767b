"""Measures what TLS with access control adds to one-way latency: ``python benchmarks/live_tls.py``.

Two routers run at once, one with keys and one without. A sender process publishes messages of the size of a
``PlantInput`` at 1 kHz as the filter does, in blocks by turns over either router, and this process receives them as a
plant. Both ways meet the same load of the machine. One-way times by the machine's monotonic clock.
"""

import multiprocessing
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout
from io import StringIO
from multiprocessing.process import BaseProcess
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Annotated

import numpy as np
import typer
import zenoh
from live_latency import free_port
from passafe_protocol.keys import DEFAULT_ROBOT
from passafe_protocol.topics import INPUT
from passafe_services.keys.credentials import load_credentials
from passafe_services.keys.deployment import Deployment, identities_of
from passafe_services.loop.bus import open_bus
from passafe_services.loop.realtime import request_realtime
from passafe_services.loop.router_endpoint import RouterEndpoint
from passafe_services.loop.session import client_settings, open_session
from passafe_services.router.process import run_router
from report import AsJson, Ratio, Report, Smallest
from timing import Times

RATE_HZ = 1000.0
BLOCK = 250
"""Messages of a block: a quarter of a second over one router, then over the other."""
PAYLOAD = bytes(88)
END = b"end"
START_S = 20.0
WAYS = ("plain", "TLS")

_SPAWN = multiprocessing.get_context("spawn")


def endpoint(keys: Path, way: str, role: str, port: int) -> RouterEndpoint:
    """Return the endpoint of a router, with the keys of a role if it has any."""
    credentials = None if way == "plain" else load_credentials(keys, role, DEFAULT_ROBOT)
    return RouterEndpoint(port=port, credentials=credentials)


def route(keys: Path, way: str, port: int) -> None:
    """Run a router until the process is terminated."""
    with redirect_stdout(StringIO()):
        run_router(endpoint(keys, way, "router", port))


def send(keys: Path, ports: tuple[int, ...], blocks: int) -> None:
    """Publish blocks of time-stamped messages, by turns over each router."""
    with ExitStack() as stack:
        buses = [
            stack.enter_context(open_bus(endpoint(keys, way, "filter", port), timeout_s=START_S))
            for way, port in zip(WAYS, ports, strict=True)
        ]
        puts = [bus.publisher(INPUT, "filter") for bus in buses]
        request_realtime()
        time.sleep(0.5)  # the receiver's declarations get about
        due_ns = time.monotonic_ns()
        for block in range(blocks):
            put = puts[block % len(puts)]
            for _ in range(BLOCK):
                due_ns += round(1e9 / RATE_HZ)
                time.sleep(max(0, due_ns - time.monotonic_ns()) / 1e9)
                put(struct.pack("q", time.monotonic_ns()) + PAYLOAD)
        for put in puts:
            put(END)
        time.sleep(0.2)


@contextmanager
def running(target: Callable[..., None], *arguments: object) -> Iterator[BaseProcess]:
    """Run a function in a process of its own; nothing of it is left afterwards."""
    process = _SPAWN.Process(target=target, args=arguments)
    process.start()
    try:
        yield process
    finally:
        process.terminate()
        process.join()


def receive(subscriber: "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]", times_us: list[float]) -> None:
    """Note how long each message took, until the one that ends it."""
    while (data := subscriber.recv().payload.to_bytes()) != END:
        times_us.append((time.monotonic_ns() - struct.unpack_from("q", data)[0]) / 1e3)


def measured_us(blocks: int) -> dict[str, Times]:
    """Return the one-way times over each router, µs, in order."""
    times_us: dict[str, list[float]] = {way: [] for way in WAYS}
    with TemporaryDirectory() as folder, ExitStack() as stack:
        keys = Path(folder) / "keys"
        Deployment.create(keys).issue(identities_of([DEFAULT_ROBOT]))
        ports = tuple(free_port() for _ in WAYS)
        threads = []
        for way, port in zip(WAYS, ports, strict=True):
            stack.enter_context(running(route, keys, way, port))
            at = endpoint(keys, way, "plant", port)
            session = open_session(client_settings(at.locator, at.credentials, START_S))
            stack.callback(session.close)
            subscriber = session.declare_subscriber(INPUT.key("filter"), zenoh.handlers.FifoChannel(BLOCK))
            threads.append(Thread(target=receive, args=(subscriber, times_us[way]), daemon=True))
            threads[-1].start()
        with running(send, keys, ports, blocks) as sender:
            sender.join()
        for thread in threads:
            thread.join(START_S)
    return {way: np.array(found) for way, found in times_us.items()}


def main(
    seconds: Annotated[float, typer.Option(min=1.0, help="Time over each router.")] = 10.0,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Report one-way latency with and without TLS, and their ratio block by block."""
    blocks = 2 if smallest else 2 * round(seconds * RATE_HZ / BLOCK)
    times_us = measured_us(blocks)
    report = Report(
        title=f"One way at {RATE_HZ:g} Hz, blocks of {BLOCK} messages by turns",
        columns=("over", "messages", "p50", "p99", "mean"),
    )
    for way, found in times_us.items():
        p50, p99 = np.percentile(found, [50, 99])
        report.rows.append((way, str(found.size), f"{p50:.0f} µs", f"{p99:.0f} µs", f"{found.mean():.0f} µs"))
        if found.size < 0.9 * BLOCK * blocks / len(WAYS):
            report.failures.append(f"{way}: got {found.size} messages, allowed at least 9 of 10")
    medians = [[float(np.median(part)) for part in np.array_split(times_us[way], blocks // 2)] for way in WAYS]
    report.ratios.append(Ratio.of_rounds("one way over TLS", medians[1], "plain", medians[0]))
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
