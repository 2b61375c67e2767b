"""Plant process."""

from contextlib import closing

from passafe_services.drivers.build import driver_of
from passafe_services.drivers.strange_driver import StrangeDriver
from passafe_services.loop.node_process import run_node
from passafe_services.loop.process_options import ProcessOptions
from passafe_services.plant.build import plant_node
from passafe_services.plant.stop_latch import NO_STOP
from passafe_services.plant_contract.plant_model import PlantModel


def start(options: ProcessOptions) -> None:
    """Move the robot until stopped, or until the end of its plant time; its driver lets it stop in any case.

    Raises:
        DriverError: There is no such robot.
    """
    scenario = options.scenario
    model = PlantModel.of(scenario)
    with closing(driver_of(scenario, model, options.driver)) as driver:
        started_with = options.epoch if options.start_stopped else NO_STOP
        node = plant_node(scenario, model, started_with=started_with, driver=driver)
        end_ns = None if options.duration_s is None else round(options.duration_s * 1e9)
        # The robot is let stop at once, not when the recorder has the last messages.
        run_node(
            node,
            options,
            finished=lambda: end_ns is not None and node.plant_ns >= end_ns,
            begun=driver.open,  # on the bus: what it raises is in the log
            ended=driver.close,
            waits_in=(lambda: driver.call) if isinstance(driver, StrangeDriver) else None,
        )
