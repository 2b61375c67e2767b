"""The pages of logs behind their real web server, in a thread of the test's process."""

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from passafe_dashboard.address import listening_socket
from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.routes.application import create_browsing_app
from passafe_dashboard.server import page_server

OVER = ("done", "failed", "cancelled")


class BrowsedArchive:
    """A running server and ways to talk to it."""

    def __init__(self, url: str, client: httpx.Client, archive: Archive) -> None:
        self.url = url
        self.archive = archive
        self._client = client

    def get(self, path: str) -> httpx.Response:
        """Ask for a path."""
        return self._client.get(self.url + path)

    def post(self, request: Any, **headers: str) -> httpx.Response:  # noqa: ANN401 - JSON
        """Ask for a job."""
        return self._client.post(f"{self.url}/api/jobs", json=request, headers=headers)

    def delete(self, job: str) -> httpx.Response:
        """Cancel a job."""
        return self._client.delete(f"{self.url}/api/jobs/{job}")

    def finished(self, request: Any) -> dict[str, Any]:  # noqa: ANN401 - JSON
        """Return a job when it is over."""
        answer = self.post(request)
        assert answer.status_code == 202, answer.text
        return self.over(answer.json()["job"])

    def over(self, job: str) -> dict[str, Any]:
        """Wait until a job is over, and return it."""
        found = {"state": "waiting", "changes": -1}
        while found["state"] not in OVER:
            found = self.get(f"/api/jobs/{job}?seen={found['changes']}").json()
        return found


@contextmanager
def browse_folder(root: Path) -> Iterator[BrowsedArchive]:
    """Serve the logs of a folder until the end of the block."""
    with listening_socket("127.0.0.1", 0) as listener, httpx.Client(timeout=30, verify=False) as client:  # noqa: S501 - no TLS here
        made: list[Archive] = []
        ready = threading.Event()
        servers: list[Any] = []

        async def serve() -> None:
            made.append(Archive(root, beside_robot=False))
            servers.append(page_server(create_browsing_app(made[0])))
            ready.set()
            await servers[0].serve(sockets=[listener])

        thread = threading.Thread(target=lambda: asyncio.run(serve()))
        thread.start()
        ready.wait(30)
        page = BrowsedArchive(f"http://127.0.0.1:{listener.getsockname()[1]}", client, made[0])
        page.get("/api/jobs")  # answered once the application has started
        try:
            yield page
        finally:
            servers[0].should_exit = True
            thread.join(30)
            assert not thread.is_alive()
