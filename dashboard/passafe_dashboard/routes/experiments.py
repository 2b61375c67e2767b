"""Serve the experiments in the runs folder: ``GET /api/experiments``, and one with ``GET /api/experiments/{name}``.

``GET /api/experiment-offers`` has those that can be started, by a job.
"""

from fastapi import APIRouter

from passafe_dashboard.archive.archive import Archive
from passafe_dashboard.archive.experiment_models import ExperimentList, ExperimentOffers, ExperimentView
from passafe_dashboard.routes.answers import UNKNOWN_NAME


def experiment_routes(archive: Archive) -> APIRouter:
    """Return the routes that show experiments."""
    router = APIRouter(tags=["experiments"])

    @router.get("/api/experiments")
    async def experiments() -> ExperimentList:
        """List the experiments, the newest first."""
        return await archive.experiments()

    @router.get("/api/experiment-offers")
    async def offers() -> ExperimentOffers:
        """List the experiments that a job of the kind ``sweep`` can start."""
        return await archive.offers()

    @router.get("/api/experiments/{name:path}", responses=UNKNOWN_NAME)
    async def experiment(name: str) -> ExperimentView:
        """Return the map of an experiment, as far as it has come."""
        return await archive.experiment(name)

    return router
