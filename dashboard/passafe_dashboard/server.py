"""Run the page's web application behind uvicorn."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

import uvicorn
from fastapi import FastAPI

from passafe_dashboard.connections import LimitedHttp, LimitedWebSocket
from passafe_dashboard.errors import PageAccessError
from passafe_dashboard.page_access import ShownCertificate

MAX_BUSY: Final = 128
"""Connections from which on requests other than of a WebSocket are answered with 503."""

PING_S: Final = 5.0
"""Time between pings of a WebSocket, and time to answer one, s."""


class PageServer(uvicorn.Server):
    """A web server that leaves the signals to its caller."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave the signal handlers as they are."""
        yield


def page_server(app: FastAPI, certificate: ShownCertificate | None = None) -> PageServer:
    """Return a server for the application, not started yet.

    Args:
        app: The application.
        certificate: Certificate to show; ``None``: without TLS.

    Raises:
        PageAccessError: The certificate cannot be used.
    """
    config = uvicorn.Config(
        app,
        log_config=None,  # uvicorn would configure logging of the whole process
        log_level="warning",
        access_log=False,
        http=LimitedHttp,
        h11_max_incomplete_event_size=16_384,  # of the head of a request
        limit_concurrency=MAX_BUSY,
        backlog=64,
        ws=LimitedWebSocket,
        ws_max_size=4096,  # a command of a page takes 200 bytes
        ws_per_message_deflate=False,  # loopback has the bandwidth; compression would cost processor time
        ws_ping_interval=PING_S,
        ws_ping_timeout=PING_S,
        timeout_graceful_shutdown=1,
        ssl_certfile=None if certificate is None else certificate.certificate,
        ssl_keyfile=None if certificate is None else certificate.key,
    )
    try:
        config.load()
    except OSError as error:  # an ssl.SSLError is one
        files = "" if certificate is None else f"{certificate.certificate} and {certificate.key}"
        raise PageAccessError("--page-certificate", f"{files} ({error.strerror or error})", "PEM files") from error
    return PageServer(config)
