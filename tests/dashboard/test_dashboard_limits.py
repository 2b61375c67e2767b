"""Clients of the page cost little: bytes, time and places are bounded."""

import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress

import httpx
import passafe_dashboard.connections
import passafe_dashboard.server
import psutil
import pytest
from passafe_dashboard.routes.state import MAX_CLIENTS
from served_page import FastRun, ServedPage, client_that_reads_nothing, frames, serve_page

LINK = "/api/links/plant-to-filter"


def send(page: ServedPage, data: bytes) -> socket.socket:
    client = socket.create_connection(("127.0.0.1", page.port), 30)
    client.sendall(data)
    return client


def is_dropped(client: socket.socket, within_s: float = 10.0) -> bool:
    """Read until the server ends the connection; tell whether it did."""
    client.settimeout(within_s)
    try:
        while client.recv(65_536):
            pass
    except TimeoutError:
        return False
    except ConnectionResetError:
        pass
    return True


def pages(page: ServedPage) -> int:
    return int(page.get("/healthz").json()["pages"])


def test_large_body_is_refused_without_being_read(page: ServedPage, run: FastRun) -> None:
    before = psutil.Process().memory_info().rss
    with send(
        page, f"PUT {LINK} HTTP/1.1\r\nHost: {page.host}\r\nContent-Length: 600000000\r\n\r\n".encode()
    ) as client:
        assert client.recv(12) == b"HTTP/1.1 413"
        with suppress(OSError):
            for _ in range(300):
                client.sendall(bytes(1_000_000))
    assert psutil.Process().memory_info().rss - before < 20e6
    assert page.put(LINK, {"quantiles_s": [0.1] * 20_000}).status_code == 413
    assert run.links.requests == []


def test_body_without_a_length_is_bounded_too(page: ServedPage) -> None:
    def endless() -> Iterator[bytes]:
        for _ in range(100):
            yield b"[" * 10_000

    try:
        answer = httpx.put(page.url + LINK, content=endless(), timeout=30)
    except httpx.WriteError:  # closed while it was still sending
        return
    assert answer.status_code == 413


def test_head_of_a_request_is_bounded(page: ServedPage) -> None:
    with send(page, b"GET / HTTP/1.1\r\nX: " + b"x" * 40_000) as client:
        assert client.recv(12) == b"HTTP/1.1 400"
        assert is_dropped(client)


def test_head_that_does_not_end_is_dropped(page: ServedPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.connections, "HEADER_S", 0.5)
    with send(page, b"") as silent, send(page, b"GET / HTTP/1.1\r\n") as slow:
        began = time.monotonic()
        while not is_dropped(slow, within_s=0.1) and time.monotonic() < began + 10:
            with suppress(OSError):
                slow.sendall(b"x")  # each byte may come in time, the head does not
        assert time.monotonic() < began + 10
        assert is_dropped(silent)


def test_body_that_does_not_come_is_dropped(page: ServedPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.connections, "REQUEST_S", 0.5)
    head = f"PUT {LINK} HTTP/1.1\r\nHost: {page.host}\r\nContent-Type: application/json\r\nContent-Length: 9\r\n\r\n{{"
    with send(page, head.encode()) as client:
        assert is_dropped(client)


def test_second_request_has_its_own_time(page: ServedPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.connections, "HEADER_S", 0.5)
    with httpx.Client(base_url=page.url) as client:
        client.get("/healthz")
        time.sleep(0.7)  # longer than the head of the first request may take
        assert client.get("/healthz").status_code == 200


def test_limit_of_pages_holds_for_simultaneous_ones(page: ServedPage) -> None:
    upgrade = (
        f"GET /live HTTP/1.1\r\nHost: {page.host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ).encode()
    with ExitStack() as stack:
        clients = [stack.enter_context(send(page, b"")) for _ in range(150)]
        for client in clients:
            client.sendall(upgrade)
        refused = 0
        for client in clients:
            client.settimeout(30)
            got = client.recv(65_536)
            while b"\r\n\r\n" not in got or not got.partition(b"\r\n\r\n")[2]:
                got += client.recv(65_536)
            refused += b"too many pages are open" in got.partition(b"\r\n\r\n")[2][:64]
        assert len(clients) - refused == MAX_CLIENTS


def test_connections_beyond_the_limit_are_closed(page: ServedPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.connections, "MAX_CONNECTIONS", 10)
    with ExitStack() as stack:
        clients = [stack.enter_context(send(page, b"")) for _ in range(20)]
        assert is_dropped(clients[-1])


def test_silent_pages_are_dropped(run: FastRun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(passafe_dashboard.server, "PING_S", 0.4)
    with serve_page(run) as page, client_that_reads_nothing(page), page.listen() as lively:
        frames(lively, 20)
        seen = {pages(page)}
        until = time.monotonic() + 10
        while pages(page) != 1 and time.monotonic() < until:
            frames(lively, 5)
        assert pages(page) == 1
        assert seen == {2}


def test_many_refused_requests_leave_nothing_behind(page: ServedPage) -> None:
    page.get("/healthz")
    before = psutil.Process().num_fds()
    for _ in range(100):
        with send(page, b"\0" * 1000) as client:
            is_dropped(client)
    page.get("/healthz")
    assert psutil.Process().num_fds() <= before + 5


@pytest.mark.parametrize(
    "body",
    [
        '{"loss": NaN}',
        '{"delay_s": 1e999}',
        '{"delay_s": -Infinity}',
        '{"\\ud800": 1}',
        "[" * 5000,
        '{"loss": "\\ud800"}',
        "\xff",
        "1" * 6000,
    ],
)
def test_json_that_is_none_is_refused(page: ServedPage, run: FastRun, body: str) -> None:
    answer = httpx.put(page.url + LINK, content=body.encode("latin-1"), headers={"content-type": "application/json"})

    assert answer.status_code in (400, 422), answer.text
    assert answer.json()["detail"]
    assert run.links.requests == []
