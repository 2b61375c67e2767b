"""Filter process."""

import time

from passafe_services.filter.build import filter_node
from passafe_services.loop.node_process import run_node
from passafe_services.loop.process_options import ProcessOptions


def start(options: ProcessOptions) -> None:
    """Run the filter until stopped."""
    epoch = time.time_ns()
    run_node(filter_node(options.scenario, "live", epoch), options, epoch=epoch)
