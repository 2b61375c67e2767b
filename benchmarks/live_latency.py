"""Measures how punctual a live system is, beside raw UDP: ``python benchmarks/live_latency.py``.

First datagrams of the size of a ``PlantInput`` go between two processes over loopback at 1 kHz, then
``passafe demo`` runs on the same machine, and its log is reviewed. One-way times by the machine's monotonic clock.
"""

import json
import multiprocessing
import os
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np
import typer
from passafe_services.loop.realtime import request_realtime
from report import AsJson, Ratio, Report, Smallest
from timing import Times

RATE_HZ = 1000.0
PAYLOAD = bytes(88)
"""Makes a datagram of 96 bytes, as large as a PlantInput."""


def send(port: int, count: int) -> None:
    """Send time-stamped datagrams at 1 kHz."""
    request_realtime()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        due = time.monotonic_ns() + 10_000_000
        for _ in range(count):
            time.sleep(max(0, due - time.monotonic_ns()) / 1e9)
            sender.sendto(struct.pack("q", time.monotonic_ns()) + PAYLOAD, ("127.0.0.1", port))
            due += round(1e9 / RATE_HZ)


def raw_udp_us(seconds: float) -> Times:
    """Return the one-way times of raw UDP between two processes, µs."""
    count = round(seconds * RATE_HZ)
    times = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(5.0)
        sender = multiprocessing.get_context("spawn").Process(target=send, args=(receiver.getsockname()[1], count))
        sender.start()
        request_realtime()
        try:
            for _ in range(count):
                sent_ns = struct.unpack_from("q", receiver.recv(256))[0]
                times.append((time.monotonic_ns() - sent_ns) / 1e3)
        except TimeoutError:
            pass  # what is lost is left out; the count is printed
        sender.join()
    if hasattr(os, "sched_setscheduler"):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    return np.array(times)


def free_port() -> int:
    """Return a port on which nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def live_timing(seconds: float) -> dict[str, Any]:
    """Return the timing part of the review of a live run."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-P", "-m", "passafe_services.cli"]
        arguments = [
            "demo",
            "--headless",
            "--duration",
            str(seconds),
            "--out",
            folder,
            "--router-port",
            str(free_port()),
        ]
        subprocess.run([*command, *arguments], check=True, stdout=subprocess.DEVNULL)  # noqa: S603 - ours
        [log] = Path(folder).glob("*.mcap")
        review = [*command, "review", str(log), "--json"]
        done = subprocess.run(review, check=True, capture_output=True, text=True)  # noqa: S603 - ours
    return dict(json.loads(done.stdout)["timing"])


def main(
    seconds: Annotated[float, typer.Option(min=0.5, help="Length of the live run and of the UDP run.")] = 10.0,
    smallest: Smallest = False,
    as_json: AsJson = False,
) -> None:
    """Report lateness of every loop, latency from operator to plant, and raw UDP."""
    if smallest:
        seconds = 1.0
    udp_us = raw_udp_us(seconds)
    timing = live_timing(seconds)
    report = Report(
        title=f"Live, {seconds:g} s at {RATE_HZ:g} Hz", columns=("what", "p50", "p99", "p99.9", "within 1 ms")
    )
    for process, late in timing["late_us"].items():
        cells = (f"{late[key]:.0f} µs" for key in ("p50", "p99", "p99_9"))
        report.rows.append((f"lateness of {process}", *cells, f"{late['within_1_ms']:.2%}"))
    route_ms = timing["operator_to_plant_ms"]
    cells = (f"{route_ms[key]:.2f} ms" for key in ("p50", "p99", "p99_9"))
    report.rows.append(("operator to plant, play-out included", *cells, ""))
    p50, p99, p999 = np.percentile(udp_us, [50, 99, 99.9])
    received = f"raw UDP one way ({udp_us.size} datagrams)"
    report.rows.append((received, f"{p50:.0f} µs", f"{p99:.0f} µs", f"{p999:.0f} µs", f"{np.mean(udp_us < 1e3):.2%}"))
    report.ratios.append(Ratio.of_rounds("operator to plant", [1e3 * route_ms["p50"]], "raw UDP", [float(p50)]))
    report.finish(as_json=as_json)


if __name__ == "__main__":
    typer.run(main)
