"""A robot that is its model, for nodes that a test steps."""

from collections.abc import Sequence

from passafe_services.drivers.model_driver import ModelDriver
from passafe_services.plant.driven_robot import DrivenRobot
from passafe_services.plant.stop_latch import StopLatch
from passafe_services.plant_contract.fail_safe import FailSafe

from passafe import SampledPlant


def modelled_robot(
    plant: SampledPlant,
    rule: FailSafe,
    *,
    x0: Sequence[float],
    period_ns: int,
    playout_ns: int = 0,
    latch: StopLatch | None = None,
) -> DrivenRobot:
    """Return a robot at rest that the model moves exactly."""
    driver = ModelDriver(plant, x0=x0, period_ns=period_ns)
    return DrivenRobot(driver, plant, rule, x0=x0, period_ns=period_ns, playout_ns=playout_ns, latch=latch)
