"""The pages of logs behind their real web server, in a thread of the test's process."""

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Queue
from threading import Thread
from typing import Any

import httpx
from passafe_dashboard.address import listening_socket
from passafe_dashboard.browsing import serve_archive
from passafe_services.loop.stop import Stop, StopReason

OVER = ("done", "failed", "cancelled")


class BrowsedArchive:
    """A running server and ways to talk to it."""

    def __init__(self, url: str, client: httpx.Client) -> None:
        self.url = url
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
        return self.until(job, lambda found: found["state"] in OVER)

    def until(self, job: str, is_there: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """Follow a job, change by change, until it is where it is waited for; return it."""
        found: dict[str, Any] = {"state": "waiting", "text": "", "changes": -1}
        while not is_there(found):
            assert found["state"] not in OVER, found
            found = self.get(f"/api/jobs/{job}?seen={found['changes']}").json()
        return found


@contextmanager
def browse_folder(root: Path) -> Iterator[BrowsedArchive]:
    """Serve the logs of a folder until the end of the block."""
    stop = Stop()
    addresses: Queue[str] = Queue()
    with listening_socket("127.0.0.1", 0) as listener, httpx.Client(timeout=30, verify=False) as client:  # noqa: S501 - no TLS here
        thread = Thread(target=lambda: asyncio.run(serve_archive(root, listener, stop, addresses.put)))
        thread.start()
        try:
            yield BrowsedArchive(addresses.get(timeout=30).removesuffix("/logs"), client)
        finally:
            stop.request(StopReason.SIGNAL)
            thread.join(30)
            assert not thread.is_alive()
