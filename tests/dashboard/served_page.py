"""The dashboard's application behind its real web server, in a thread of the test's process."""

import asyncio
import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import httpx
from answering_links import AnsweringLinks
from closed_form import ClosedFormRun
from fastapi import FastAPI
from msgspec import structs
from passafe_dashboard.address import listening_socket
from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.drive_requests import DriveRequests
from passafe_dashboard.live.feed import Feed
from passafe_dashboard.live.link_requests import LinkRequests
from passafe_dashboard.live.stop_requests import StopRequests
from passafe_dashboard.page_access import PageAccess, shown_certificate
from passafe_dashboard.routes.application import create_app
from passafe_dashboard.server import page_server
from passafe_protocol.messages import EmergencyStop, FilterTick, Header, PlantState, Received, Steer, StopClear
from passafe_services.loop.pace import Pace
from passafe_services.plant.stop_latch import StopLatch
from websockets.sync.client import ClientConnection, connect


class FastRun:
    """A closed-form run in which time passes ``speed`` times as fast as it does.

    Attributes:
        speed: May be changed; 0 until then means that nothing happens.
        fails: Set it to make reading raise.
        next_tick: Fields to change in the next tick, once.
        links: Links that answer.
        latch: Emergency stop that answers.
        stop_requests: Requests to it.
        steered: What was published of who drives.
        runs: Folder of logs to show besides, if any.
    """

    def __init__(self, feed: Feed, *, speed: float = 5.0, frame_hz: float = 100.0) -> None:
        self.feed = feed
        self.speed = speed
        self.fails = False
        self.next_tick: dict[str, Any] = {}
        self.links = AnsweringLinks(feed)
        self.broadcast = Broadcast(feed, read=self._read, clock=time.monotonic_ns, frame_hz=frame_hz)
        self.latch = StopLatch()
        self.stop_requests: list[EmergencyStop | StopClear] = []
        self.steered: SimpleQueue[Steer] = SimpleQueue()
        self.runs: Path | None = None
        self._before_ns: int | None = None
        self._run_ns = 0.0
        self._run = ClosedFormRun(period_ms=10, scenario=feed.scenario)

    def app(self, answer_s: float = 3.0, access: PageAccess | None = None) -> FastAPI:
        """Return the application that shows the run."""
        links = LinkRequests(self.broadcast, self.links.request, answer_s=answer_s)
        stops = StopRequests(self.broadcast, self.request_stop, epoch=1, answer_s=answer_s)
        drives = DriveRequests(self.broadcast, self.steer, lambda now_ns: (1, now_ns, 0))
        archive = None if self.runs is None else Archive(self.runs, beside_robot=True)
        return create_app(self.broadcast, links, stops, drives, access=access, archive=archive)

    def steer(self, body: Steer, _now_ns: int) -> None:
        """Keep what is published."""
        self.steered.put(body)

    def request_stop(self, body: EmergencyStop | StopClear, _now_ns: int) -> None:
        """Answer as a plant with a latch does, unless it is silent."""
        self.stop_requests.append(body)
        if not self.links.silent:
            self.latch.receive(Received(Header("dashboard", 1, 0, 0, 0, 0, 0), body, 0))

    def _read(self, now_ns: int, pace: Pace) -> None:
        del pace
        if self.fails:
            raise RuntimeError("reading is broken")
        if self._before_ns is None:
            self.links.publish_states(now_ns, "start")
        self.links.answer(now_ns)
        self._run_ns += self.speed * (now_ns - (self._before_ns or now_ns))
        self._before_ns = now_ns
        for header, body, _ in self._run.until(int(self._run_ns)):
            if isinstance(body, FilterTick) and self.next_tick:
                body = structs.replace(body, **self.next_tick)  # noqa: PLW2901 - stands in for what came
                self.next_tick = {}
            if isinstance(body, PlantState):
                latch = self.latch
                stop = {"stop": latch.stop, "stop_source": latch.source, "stops_cleared": latch.cleared}
                body = structs.replace(body, **stop)  # noqa: PLW2901 - likewise
            self.feed.push(header, body, now_ns)


class ServedPage:
    """A running server and ways to talk to it."""

    def __init__(self, port: int, loop: asyncio.AbstractEventLoop, client: httpx.Client, scheme: str = "http") -> None:
        self._client = client
        self.host = f"127.0.0.1:{port}"
        self.url = f"{scheme}://{self.host}"
        self.port = port
        self._loop = loop

    def get(self, path: str) -> httpx.Response:
        """Ask for a path."""
        return self._client.get(self.url + path)

    def listen(self, **options: Any) -> ClientConnection:  # noqa: ANN401 - of connect()
        """Open the WebSocket."""
        return connect(f"ws://{self.host}/live", compression=None, max_queue=None, **options)

    def put(self, path: str, json: object, **headers: str) -> httpx.Response:
        """Put JSON to a path."""
        return self._client.put(self.url + path, json=json, headers=headers)

    def in_loop(self, function: Callable[..., object], *arguments: object) -> None:
        """Call a function in the server's event loop and wait for it."""

        async def call() -> None:
            function(*arguments)

        asyncio.run_coroutine_threadsafe(call(), self._loop).result(30)


@contextmanager
def serve_page(
    run: FastRun, *, port: int = 0, answer_s: float = 30.0, access: PageAccess | None = None
) -> Iterator[ServedPage]:
    """Serve until the end of the block."""
    with listening_socket("127.0.0.1", port) as listener, httpx.Client(timeout=30, verify=False) as client:  # noqa: S501 - no TLS here
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)  # so that a slow reader is felt soon
        with shown_certificate(access or PageAccess(), ["127.0.0.1"]) as shown:
            server = page_server(run.app(answer_s, access), shown)
        loop = asyncio.new_event_loop()
        thread = threading.Thread(target=_run, args=(loop, server.serve(sockets=[listener])))
        thread.start()
        scheme = "https" if access is not None and access.is_encrypted else "http"
        page = ServedPage(listener.getsockname()[1], loop, client, scheme)
        page.get("/healthz")  # answered once the application has started
        try:
            yield page
        finally:
            client.close()  # TLS waits for its end
            server.should_exit = True
            thread.join(30)
            assert not thread.is_alive()


def _run(loop: asyncio.AbstractEventLoop, serving: Any) -> None:  # noqa: ANN401 - a coroutine
    with asyncio.Runner(loop_factory=lambda: loop) as runner:
        runner.run(serving)


def frames(connection: ClientConnection, count: int) -> list[dict[str, Any]]:
    return [json.loads(connection.recv(timeout=30)) for _ in range(count)]


@contextmanager
def client_that_reads_nothing(page: ServedPage) -> Iterator[socket.socket]:
    """Return a WebSocket client with a small receive buffer that never reads after the handshake."""
    with socket.socket() as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.connect(("127.0.0.1", page.port))
        client.sendall(
            f"GET /live HTTP/1.1\r\nHost: {page.host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        client.settimeout(30)
        assert client.recv(12) == b"HTTP/1.1 101"
        yield client
