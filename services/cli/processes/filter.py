"""The filter as a process."""

import time

from services.assembly import filter_node
from services.cli.processes.live import run_node
from services.cli.processes.options import ProcessOptions


def start(options: ProcessOptions) -> None:
    """Filter until told to stop."""
    epoch = time.time_ns()
    run_node(filter_node(options.scenario, "live", epoch), options, epoch=epoch)
