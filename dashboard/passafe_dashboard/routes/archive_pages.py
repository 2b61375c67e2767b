"""Serve the pages of logs, comparisons, jobs and experiments; their scripts ask the API for all that is in them."""

from typing import Any

from fastapi import APIRouter, Response
from fastapi.responses import HTMLResponse

from passafe_dashboard.markup import TEMPLATES
from passafe_dashboard.reports.run_page import report_style


def archive_pages(*, live: bool) -> APIRouter:
    """Return the routes of the pages.

    Args:
        live: Whether there is a robot to drive and to stop beside the logs.
    """
    router = APIRouter(include_in_schema=False)

    def page(template: str, sheet: str, **values: Any) -> HTMLResponse:  # noqa: ANN401 - a template's
        return HTMLResponse(TEMPLATES.get_template(template).render(live=live, sheet=sheet, **values))

    @router.get("/logs")
    async def logs() -> HTMLResponse:
        return page("logs.html", "logs")

    @router.get("/logs/{name:path}")
    async def log(name: str) -> HTMLResponse:
        return page("log.html", "logs", name=name)

    @router.get("/compare")
    async def compare() -> HTMLResponse:
        return page("compare.html", "logs")

    @router.get("/jobs/{name}")
    async def job(name: str) -> HTMLResponse:
        return page("job.html", "logs", name=name)

    @router.get("/experiments")
    async def experiments() -> HTMLResponse:
        return page("experiments.html", "experiments")

    @router.get("/experiments/{name:path}")
    async def experiment(name: str) -> HTMLResponse:
        return page("experiment_map.html", "experiments", name=name)

    @router.get("/report.css")
    async def style() -> Response:
        return Response(report_style(), media_type="text/css")

    return router
