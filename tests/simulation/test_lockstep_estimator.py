"""The closed loop with the human-input estimator in the filter."""

from pathlib import Path

import numpy as np
import pytest
from passafe_protocol.messages import FilterStatus, FilterTick
from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.load import load_scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.replay.replay_log import replay_filter
from passafe_services.tools.review.run_log import RunLog

ESTIMATOR = {"kind": "white-acceleration", "agility": 30.0, "resolution": 0.1}
BAD_LINK = {"delay_s": 0.03, "jitter_s": 0.02, "loss": 0.2, "seed": 5}


def logged(path: Path, **overrides: object) -> RunLog:
    values: dict[str, object] = {key.replace("__", "."): value for key, value in overrides.items()}
    scenario = load_scenario("notomista-cai-2020", {"duration_s": 1.0, **values})
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as log:
        lockstep_loop(scenario, LockstepLog(log)).run(steps_of(scenario))
    return RunLog.read(path)


def test_estimate_over_a_bad_link_is_accurate_and_replayable(tmp_path: Path) -> None:
    overrides = {"operator.estimator": ESTIMATOR, "links.operator-to-filter": BAD_LINK}
    log = logged(tmp_path / "run.mcap", **overrides)
    ticks = [message.body for message in log.of(FilterTick)][200:]
    t_s = np.array([tick.effective_plant_ns * 1e-9 for tick in ticks])
    rate = np.array([tick.u_h_rate[0] for tick in ticks])
    lag = 0.03 + 0.005  # least delay of the link would be 0.01; the play-out time comes on top

    assert replay_filter(log).exact
    assert not {tick.status for tick in ticks} & {FilterStatus.UNCERTIFIED, FilterStatus.STALE}
    assert np.isfinite(rate).all()
    assert np.abs(rate - -15.0 * np.exp(-(t_s - lag) / 0.2)).max() < 2.5


def test_the_sources_own_rate_is_not_what_phi_sees(tmp_path: Path) -> None:
    sent = [m.body for m in logged(tmp_path / "sent.mcap", duration_s=0.1).of(FilterTick)]
    estimated = [
        m.body
        for m in logged(tmp_path / "estimated.mcap", duration_s=0.1, operator__estimator=ESTIMATOR).of(FilterTick)
    ]

    assert estimated[2].u_h_rate == (0.0, 0.0)
    assert estimated[-1].u_h_rate != sent[-1].u_h_rate
    assert estimated[-1].u_h_rate[0] == pytest.approx(sent[-1].u_h_rate[0], rel=0.05)


def test_as_sent_is_the_default_to_the_last_bit(tmp_path: Path) -> None:
    default = logged(tmp_path / "default.mcap", duration_s=0.1)
    explicit = logged(tmp_path / "explicit.mcap", duration_s=0.1, operator__estimator={"kind": "as-sent"})

    assert [m.body for m in default.of(FilterTick)] == [m.body for m in explicit.of(FilterTick)]
    assert replay_filter(explicit).exact


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "telepathy"},
        {"kind": "as-sent", "agility": 1.0},
        {"kind": "white-acceleration"},
        ESTIMATOR | {"horizon_s": 1.5},
        ESTIMATOR | {"fade_s": 0.0},
        ESTIMATOR | {"resolution": 1e-9},
        ESTIMATOR | {"agility": 1e6},
    ],
)
def test_an_estimator_that_cannot_work_is_named(wrong: dict[str, object]) -> None:
    with pytest.raises(ScenarioError, match="estimator"):
        load_scenario("notomista-cai-2020", {"operator.estimator": wrong})
