"""Plant process."""

from passafe_services.loop.node_process import run_node
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.plant.build import plant_node
from passafe_services.plant.stop_latch import NO_STOP


def start(options: ProcessOptions) -> None:
    """Simulate the robot until stopped, or until the end of its plant time."""
    node = plant_node(options.scenario, started_with=options.epoch if options.start_stopped else NO_STOP)
    end_ns = None if options.duration_s is None else round(options.duration_s * 1e9)
    run_node(node, options, finished=lambda: end_ns is not None and node.plant_ns >= end_ns)
