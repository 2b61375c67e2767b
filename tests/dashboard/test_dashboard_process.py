import json
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from closed_form import header, state, tick
from passafe_protocol.codec import encode
from passafe_protocol.topics import STATE, TICK
from passafe_services.loop.bus import open_bus
from passafe_services.loop.readiness import ready_line
from passafe_services.loop.router_endpoint import RouterEndpoint
from served_page import frames
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

pytestmark = pytest.mark.live

CHILD = Path(__file__).with_name("serving_child.py")
PATIENCE_S = 60.0


@contextmanager
def child(*arguments: object) -> Iterator[subprocess.Popen[str]]:
    """Start a process that does not outlive the block."""
    process = subprocess.Popen(
        [sys.executable, str(CHILD), *map(str, arguments)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=CHILD.parents[2],
    )
    with process:
        try:
            yield process
        finally:
            if process.poll() is None:
                process.kill()


def lines_until(process: subprocess.Popen[str], wanted: str) -> list[str]:
    assert process.stdout is not None
    lines = []
    for line in process.stdout:
        lines.append(line.rstrip("\n"))
        if lines[-1] == wanted:
            return lines
    raise AssertionError((lines, process.stderr.read() if process.stderr else ""))


@pytest.fixture(scope="module")
def router_port() -> Iterator[int]:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    with child(port, "router") as router:
        lines_until(router, ready_line("router"))
        yield port


@contextmanager
def dashboard(router_port: int) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Start a dashboard; yield it and its address, host:port."""
    with child(router_port, 0) as process:
        said = lines_until(process, ready_line("dashboard"))
        address = re.fullmatch(r"page at http://([\d.]+:\d+)/", said[0])
        assert address is not None
        yield process, address.group(1)


def ok_processes(now: dict[str, Any]) -> list[str]:
    return [process["process"] for process in now["processes"] if process["state"] == "ok"]


def test_messages_of_the_bus_reach_the_page(router_port: int) -> None:
    with dashboard(router_port) as (_, address), open_bus(RouterEndpoint(port=router_port)) as bus:
        put_tick, put_state = bus.publisher(TICK, "filter"), bus.publisher(STATE, "plant")
        with connect(f"ws://{address}/live", compression=None, max_queue=None) as page:
            until = time.monotonic() + PATIENCE_S
            for k in range(1_000_000):
                put_tick(encode(header("filter", k), tick(k * 10)))
                put_state(encode(header("plant", k), state(k * 10)))
                now = frames(page, 1)[0]["now"]
                if now["filter"] and now["plant"] and ok_processes(now) == ["dashboard"]:
                    break
                assert time.monotonic() < until
        assert now["liveness"]["state"] == "live"
        assert now["topics"][0]["gaps"] == 0
        assert httpx.get(f"http://{address}/healthz", timeout=PATIENCE_S).json()["ok"] is True


def test_health_is_not_ok_without_a_router() -> None:
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    with child(port, "router") as router:
        lines_until(router, ready_line("router"))
        with dashboard(port) as (_, address):
            assert httpx.get(f"http://{address}/healthz", timeout=PATIENCE_S).json()["trouble"] == ""
            router.kill()
            until, answer = time.monotonic() + PATIENCE_S, None
            while (answer is None or answer.status_code == 200) and time.monotonic() < until:
                answer = httpx.get(f"http://{address}/healthz", timeout=PATIENCE_S)
            assert answer is not None
            assert answer.status_code == 503
            assert answer.json() | {"feed": {}} == {
                "ok": False,
                "trouble": "no router is connected",
                "pages": 0,
                "feed": {},
            }


def test_sigterm_sends_a_last_frame_and_ends_the_process(router_port: int) -> None:
    with (
        dashboard(router_port) as (process, address),
        connect(f"ws://{address}/live", compression=None, max_queue=None) as page,
    ):
        frames(page, 1)
        process.send_signal(signal.SIGTERM)
        states = []
        try:
            while True:
                states.append(json.loads(page.recv(timeout=PATIENCE_S))["now"]["liveness"]["state"])
        except ConnectionClosed:
            pass
        out, error = process.communicate(timeout=PATIENCE_S)
    assert states[-1] == "ended"
    assert process.returncode == 0
    assert out.splitlines()[-1] == "ended by SIGNAL"
    assert error == ""


def test_the_end_of_the_lifeline_ends_the_process(router_port: int) -> None:
    with dashboard(router_port) as (process, _):
        out, error = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert out.splitlines()[-1] == "ended by LIFELINE"
    assert error == ""


def test_a_taken_port_ends_the_process_with_its_error(router_port: int) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        with child(router_port, port) as process:
            _, error = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert f"dashboard port {port} on 127.0.0.1 is in use" in error.splitlines()[-1]
