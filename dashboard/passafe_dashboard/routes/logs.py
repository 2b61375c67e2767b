"""Serve the logs in the runs folder: ``GET /api/logs``, and one of them with ``GET /api/logs/{name}``."""

from fastapi import APIRouter

from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.archive.log_list import LogEntry, LogList
from passafe_dashboard.routes.answers import UNKNOWN_NAME


def log_routes(archive: Archive) -> APIRouter:
    """Return the routes that list logs."""
    router = APIRouter(tags=["logs"])

    @router.get("/api/logs")
    async def logs() -> LogList:
        """List the logs, the newest first."""
        return await archive.logs()

    @router.get("/api/logs/{name:path}", responses=UNKNOWN_NAME)
    async def log(name: str) -> LogEntry:
        """Return what the list says of one log."""
        return await archive.log(name)

    return router
