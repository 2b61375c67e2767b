"""The dashboard as a process."""

from dashboard.process import serve
from services.cli.processes.options import ProcessOptions


def start(options: ProcessOptions) -> None:
    """Serve the live page until told to stop."""
    serve(options.endpoint, options.port, host=options.host, scenario=options.scenario, lifeline=options.lifeline)
