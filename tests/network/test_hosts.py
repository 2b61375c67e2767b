"""Processes on different hosts, whose clocks differ, with a router in the middle and a bad network to the robot.

The relay is a program of its own and knows nothing of the links that passafe injects. Both are compared by a time that
one clock measures: from a state of the plant to its application of the input that the filter made of it.
"""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from host_run import host_run
from network_hosts import why_not
from passafe_protocol.messages import FilterTick, PlantState
from passafe_protocol.topics import STATE
from passafe_services.scenarios.load import load_scenario
from passafe_services.tools.review.core_evaluator import CoreEvaluator
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

pytestmark = pytest.mark.campaign

RATE_HZ = 250.0
DRIVEN_S = 8.0
DELAY_S = 0.1
JITTER_S = 0.01
LINKS_OF_THE_ROBOT = ("plant-to-filter", "filter-to-plant", "plant-to-operator")


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Verdict and timing of a run, from its log.

    Attributes:
        verdict: The review's.
        loop_s: Time from sending a state to the step that applies the input made of it, by the plant's clock, of the
            quickest tenth: a machine that stumbles makes the filter play out later for a while.
        clocks: Monotonic clocks of plant and filter.
    """

    verdict: Verdict
    loop_s: float
    clocks: set[int]

    @property
    def broken(self) -> set[str]:
        """Required properties that do not hold."""
        return {name for name, judged in self.verdict.properties.items() if judged.required and not judged.holds}


def run_over_hosts(folder: Path, *, relay: dict[str, float], links: dict[str, float]) -> Outcome:
    """Drive over a relay, or over injected links."""
    injected = {f"links.{name}.{key}": value for name in LINKS_OF_THE_ROBOT for key, value in links.items()}
    scenario = load_scenario("notomista-cai-2020", {"rate_hz": RATE_HZ, "plant.playout_s": 0.02} | injected)
    folder.mkdir(exist_ok=True)
    file = folder / "scenario.json"
    file.write_text(scenario.model_dump_json(), encoding="utf-8")
    options = [word for key, value in relay.items() for word in (f"--{key}", str(value))]
    with host_run(folder, file, options) as run:
        time.sleep(DRIVEN_S)  # what is judged is a drive of this length
        run.stop()
    log = RunLog.read(run.log)
    assert log.finished
    heads = [logged.header for body in (FilterTick, PlantState) for logged in log.of(body)]
    return Outcome(
        verdict=Verdict.of(log, CoreEvaluator(log.identity.scenario)),
        loop_s=quick_loop_s(log),
        clocks={head.clock_id for head in heads},
    )


def quick_loop_s(log: RunLog) -> float:
    states = log.of(PlantState)
    sent_ns = {state.header.sequence: state.header.sent_ns for state in states}
    applied = np.maximum.accumulate([state.body.applied_tick for state in states])
    loops_s = []
    for tick in log.of(FilterTick):
        newest = max((one.sequence for one in tick.body.consumed if one.topic == STATE.name), default=-1)
        at = int(np.searchsorted(applied, tick.body.tick))
        if newest in sent_ns and 0 < at < len(states):
            loops_s.append((states[at].header.started_ns - sent_ns[newest]) * 1e-9)
    return float(np.percentile(loops_s[len(loops_s) // 4 :], 10))


@pytest.fixture(scope="module", autouse=True)
def hosts_are_possible() -> None:
    """Skip where this machine cannot have such hosts, and say why."""
    reason = why_not()
    if reason:
        pytest.skip(reason)


@pytest.mark.parametrize(
    "relay", [{}, {"delay": DELAY_S, "jitter": JITTER_S, "loss": 0.002}], ids=["good network", "bad network"]
)
def test_robot_is_driven_across_hosts_with_other_clocks(tmp_path: Path, relay: dict[str, float]) -> None:
    outcome = run_over_hosts(tmp_path, relay=relay, links={})

    assert len(outcome.clocks) == 2
    assert outcome.verdict.h_min is not None
    assert outcome.verdict.h_min >= 0
    assert outcome.broken == set()
    assert outcome.loop_s >= 2 * relay.get("delay", 0.0)


def test_injected_link_delays_as_the_relay_does(tmp_path: Path) -> None:
    relayed = run_over_hosts(tmp_path / "relayed", relay={"delay": DELAY_S}, links={})
    injected = run_over_hosts(tmp_path / "injected", relay={}, links={"delay_s": DELAY_S})

    assert relayed.broken == injected.broken == set()
    assert relayed.loop_s >= 2 * DELAY_S
    # Both were 0.240 s on an idle machine: twice the delay, and the play-out; a stumble costs some periods of 4 ms.
    assert relayed.loop_s == pytest.approx(injected.loop_s, abs=0.012), (relayed.loop_s, injected.loop_s)
