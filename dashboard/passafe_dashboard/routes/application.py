"""Assemble the web application from its routes and static files."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Final

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from fastapi.staticfiles import StaticFiles
from starlette.types import Lifespan

from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.errors import ArchiveNameError, JobNameError, TooManyJobsError
from passafe_dashboard.live.broadcast import Broadcast
from passafe_dashboard.live.drive_requests import DriveRequests
from passafe_dashboard.live.link_requests import LinkRequests
from passafe_dashboard.live.page import LivePage
from passafe_dashboard.live.session_requests import SessionRequests
from passafe_dashboard.live.stop_requests import StopRequests
from passafe_dashboard.markup import STATIC
from passafe_dashboard.page_access import PageAccess
from passafe_dashboard.routes.answers import ANY_ROUTE
from passafe_dashboard.routes.archive_pages import archive_pages
from passafe_dashboard.routes.drive import drive_routes
from passafe_dashboard.routes.experiments import experiment_routes
from passafe_dashboard.routes.jobs import job_routes
from passafe_dashboard.routes.links import link_routes
from passafe_dashboard.routes.logs import log_routes
from passafe_dashboard.routes.own_hosts import OwnHosts, OwnHostsOnly
from passafe_dashboard.routes.page import page_routes
from passafe_dashboard.routes.page_token import TokenOnly
from passafe_dashboard.routes.refusals import (
    METHOD_NOT_ALLOWED,
    answer_invalid,
    answer_not_allowed,
    answer_too_many,
    answer_unknown_name,
)
from passafe_dashboard.routes.run import run_routes
from passafe_dashboard.routes.state import state_routes
from passafe_dashboard.routes.stop import stop_routes

HEADERS: Final = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; connect-src 'self'; img-src 'self' data: blob:; "
        "style-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}
"""The browser loads nothing from other hosts, and runs and styles nothing that stands in the markup itself."""

MAX_BODY_BYTES: Final = 65_536
"""Largest body of a request: the settings of a link with the longest histogram take a few kB."""


def create_app(
    broadcast: Broadcast,
    links: LinkRequests,
    stops: StopRequests,
    drives: DriveRequests,
    *,
    session: SessionRequests | None = None,
    hosts: OwnHosts | None = None,
    access: PageAccess | None = None,
    bus_trouble: Callable[[], str] = str,
    window_s: float = 20.0,
    archive: Archive | None = None,
) -> FastAPI:
    """Return the application.

    While it runs, ``app.state.broadcasting`` is the task that reads the bus and says who drives; it ends only by
    failing.

    Args:
        broadcast: Source of the state and of the frames.
        links: Changes links.
        stops: Presses and clears the emergency stop.
        drives: Lets pages drive.
        session: Starts and ends the runs of a demo; refuses if not given.
        hosts: Hosts by which the page may be asked for; those of loopback if not given.
        access: Token that is asked for; none if not given.
        bus_trouble: Says why nothing can be read from the bus; empty if that is not so.
        window_s: Stretch of time that charts show.
        archive: Logs to show besides; it is closed at the end.
    """
    page = LivePage(broadcast.feed, window_s=window_s)
    runs = session or SessionRequests(broadcast.feed)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        app.state.broadcasting = asyncio.create_task(_run_both(broadcast, drives))
        session_open = asyncio.create_task(runs.run())
        yield
        session_open.cancel()
        app.state.broadcasting.cancel()
        await asyncio.wait({app.state.broadcasting, session_open})
        if archive is not None:
            await archive.close()

    app = _bare_app(lifespan, hosts, access)
    app.include_router(page_routes(page))
    app.include_router(state_routes(broadcast, bus_trouble))
    app.include_router(link_routes(links))
    app.include_router(stop_routes(stops))
    app.include_router(drive_routes(broadcast, drives))
    app.include_router(run_routes(runs, broadcast.feed))
    app.state.archive = archive
    if archive is not None:
        _include_archive(app, archive, live=True)
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    return app


def create_browsing_app(archive: Archive, *, hosts: OwnHosts | None = None) -> FastAPI:
    """Return the application that shows logs alone.

    Args:
        archive: The logs; it is closed at the end.
        hosts: Hosts by which the page may be asked for; those of loopback if not given.
    """

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        yield
        await archive.close()

    app = _bare_app(lifespan, hosts)
    _include_archive(app, archive, live=False)
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    return app


def _bare_app(lifespan: Lifespan[FastAPI], hosts: OwnHosts | None, access: PageAccess | None = None) -> FastAPI:
    """Return an application that refuses what is not asked of it by its own pages, and has no routes yet."""
    app = FastAPI(
        title="passafe dashboard",
        lifespan=lifespan,
        docs_url=None,
        redoc_url=None,
        openapi_url="/openapi.json",
        redirect_slashes=False,  # a path that nobody has is not found, also with a slash behind it
        max_body_size=MAX_BODY_BYTES,
        responses=ANY_ROUTE,
    )
    app.add_exception_handler(RequestValidationError, answer_invalid)
    app.add_exception_handler(METHOD_NOT_ALLOWED, answer_not_allowed)
    if access is not None and access.token:
        app.add_middleware(TokenOnly, token=access.token, is_encrypted=access.is_encrypted)
    app.add_middleware(OwnHostsOnly, hosts=hosts or OwnHosts())
    app.middleware("http")(_add_headers)
    return app


async def _run_both(broadcast: Broadcast, drives: DriveRequests) -> None:
    await asyncio.gather(broadcast.run(), drives.run())


def _include_archive(app: FastAPI, archive: Archive, *, live: bool) -> None:
    app.add_exception_handler(ArchiveNameError, answer_unknown_name)
    app.add_exception_handler(JobNameError, answer_unknown_name)
    app.add_exception_handler(TooManyJobsError, answer_too_many)
    app.include_router(log_routes(archive))
    app.include_router(job_routes(archive))
    app.include_router(experiment_routes(archive))
    app.include_router(archive_pages(live=live))


async def _add_headers(request: Request, call_next: Callable[[Request], Awaitable[Response]]) -> Response:
    response = await call_next(request)
    for name, value in HEADERS.items():
        response.headers.setdefault(name, value)
    return response
