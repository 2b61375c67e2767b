"""Filter process."""

from passafe_services.filter.build import filter_node
from passafe_services.loop.monotonic_clock import monotonic_clock_id
from passafe_services.loop.node_process import run_node
from passafe_services.loop.process_options import ProcessOptions


def start(options: ProcessOptions) -> None:
    """Run the filter until stopped."""
    node = filter_node(options.scenario, "live", options.epoch, clock_id=monotonic_clock_id())
    run_node(node, options)
