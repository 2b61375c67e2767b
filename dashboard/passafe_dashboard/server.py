"""Run the page's web application behind uvicorn."""

from collections.abc import Iterator
from contextlib import contextmanager

import uvicorn
from fastapi import FastAPI


class PageServer(uvicorn.Server):
    """A web server that leaves the signals to its caller."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave the signal handlers as they are."""
        yield


def page_server(app: FastAPI) -> PageServer:
    """Return a server for the application, not started yet."""
    config = uvicorn.Config(
        app,
        log_config=None,  # uvicorn would configure logging of the whole process
        log_level="warning",
        access_log=False,
        ws="websockets-sansio",
        ws_per_message_deflate=False,  # loopback has the bandwidth; compression would cost processor time
        ws_ping_interval=5.0,
        ws_ping_timeout=10.0,
        timeout_graceful_shutdown=1,
    )
    return PageServer(config)
