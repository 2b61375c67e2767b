"""Filter process."""

from passafe_services.filter.build import CompiledFilter, filter_node
from passafe_services.loop.machine_code import machine_code
from passafe_services.loop.monotonic_clock import monotonic_clock_id
from passafe_services.loop.node_process import run_node
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.plant_contract.plant_model import PlantModel


def start(options: ProcessOptions) -> None:
    """Run the filter until stopped."""
    model = PlantModel.of(options.scenario)
    compiled = CompiledFilter.of(options.scenario, model.robot, machine_code)
    node = filter_node(options.scenario, "live", options.epoch, model, compiled, clock_id=monotonic_clock_id())
    run_node(node, options)
