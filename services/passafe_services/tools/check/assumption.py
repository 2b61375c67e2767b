"""Findings on what a scenario assumes of its robot: guard and sets, and whether its simulated truth lies in them."""

from collections.abc import Iterator

from passafe.finding import Finding, Severity
from passafe.models.robot import Robot
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.uncertain_robot import uncertainty_of


def assumption_findings(scenario: Scenario, robot: Robot) -> Iterator[Finding]:
    """Yield whether there is a guard, and parameters of the truth that the sets do not contain.

    Raises:
        ScenarioError: Sets that do not fit the robot.
    """
    if scenario.is_exact:
        return
    guard = "judges every input at the plant" if scenario.has_guard else "none: what the filter sends is applied"
    yield Finding(severity=Severity.NOTE, topic="guard", subject="plant", found=guard)
    truth, sets = scenario.plant.truth, uncertainty_of(scenario, robot)
    model = {parameter.name: parameter.value for parameter in robot.system.parameters}
    for name, value in ({} if truth is None else truth.parameters).items():
        nominal = model.get(name, value)
        low, high = (nominal, nominal) if sets is None else sets.parameters.get(name, (nominal, nominal))
        if not low <= value <= high:
            yield Finding(
                severity=Severity.WARNING,
                topic="truth",
                subject=f"parameter {name!r}",
                found=f"{value:g}, outside of what the rows hold for, {low:g} to {high:g}",
                advice="widen its interval in [uncertainty], unless it is to be seen what happens",
            )
