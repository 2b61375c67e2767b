"""Verdicts on a robot whose plant knows its state by sensors alone."""

from pathlib import Path

import pytest
from damped_point_run import Run, rollout, scenario
from passafe_protocol.messages import PlantState
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.uncertain_robot import reading_error_of
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

REST = (0.0, 0.0)
SENSORS = {"state_error": {"position": 0.01, "velocity": 0.1}}


def read_scenario(*, driver: bool = True, guard: dict[str, object] | None = None) -> Scenario:
    """Return the paper's scenario with a robot behind a driver, read to within 1 cm."""
    content = scenario(mode="safe").model_dump(mode="json", exclude_unset=True)
    content["uncertainty"] = SENSORS
    if driver:
        content["plant"]["driver"] = {"kind": "udp-servo", "port": 4000}
    if guard is not None:
        content["plant"]["guard"] = guard
    return Scenario.model_validate(content)


def verdict(folder: Path, asks: Scenario, x: float, true_x: float | None = None) -> Verdict:
    """Return the verdict on a robot at rest left of the disk, one of whose states was read at x."""
    run = Run(scenario=asks)
    rollout(run, x0=(-1.2, 0.0, 0.0, 0.0), u=lambda _: REST, steps=20)
    for k, index in enumerate(run.indices(PlantState)):
        where, true = (x, true_x) if k == 10 else (-1.2, -1.2)
        known = {} if true_x is None else {"true_x": (true, 0.0, 0.0, 0.0)}
        run.replace(index, x=(where, 0.0, 0.0, 0.0), **known)
    log = RunLog.read(run.write(folder / "run.mcap"))
    return Verdict.of(log, CoreEvaluator(asks), derives=False)


@pytest.mark.parametrize(("x", "holds"), [(-1.001, True), (-0.999, None), (-0.9951, None), (-0.98, False)])
def test_what_a_sensor_may_be_wrong_by_is_no_violation(tmp_path: Path, x: float, *, holds: bool | None) -> None:
    safe = verdict(tmp_path, read_scenario(), x).properties["safe"]

    assert safe.holds is holds
    assert safe.worst == pytest.approx(min(x**2 - 1, 0.44))
    assert ("error of the states as read" in safe.note) == (holds is None)


def test_true_states_have_no_error(tmp_path: Path) -> None:
    inside = verdict(tmp_path, read_scenario(), -1.1, true_x=-0.999).properties["safe"]
    outside = verdict(tmp_path, read_scenario(), -0.999, true_x=-1.1).properties["safe"]

    assert (inside.holds, outside.holds) == (False, True)
    assert outside.worst == pytest.approx(1.1**2 - 1)


def test_states_of_a_model_have_no_error(tmp_path: Path) -> None:
    assert verdict(tmp_path, read_scenario(driver=False), -0.999).properties["safe"].holds is False


def test_a_guard_says_how_well_the_plant_reads() -> None:
    asks = read_scenario(guard={"state_error": {"position": 0.002, "velocity": 0.02}})
    of_model = read_scenario(driver=False)

    assert reading_error_of(asks, robot_of(asks)) == (0.002, 0.002, 0.02, 0.02)
    assert reading_error_of(read_scenario(), robot_of(asks)) == (0.01, 0.01, 0.1, 0.1)
    assert reading_error_of(of_model, robot_of(of_model)) == (0.0,) * 4
