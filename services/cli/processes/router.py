"""The router as a process."""

from services.cli.processes.options import ProcessOptions
from services.router.process import run_router


def start(options: ProcessOptions) -> None:
    """Route until told to stop."""
    run_router(options.endpoint.port, host=options.endpoint.host, lifeline=options.lifeline)
