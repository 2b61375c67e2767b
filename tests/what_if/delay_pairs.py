"""Pairs of runs: a what-if under 150 ms more, and the run recorded under them."""

from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any, Final

from passafe_services.log.log_writer import LogWriter, run_metadata
from passafe_services.recorder.lockstep_log import LockstepLog
from passafe_services.scenarios.load import load_scenario
from passafe_services.scenarios.schema import Scenario
from passafe_services.simulation import lockstep_loop, steps_of
from passafe_services.tools.compare.comparison import Comparison
from passafe_services.tools.compare.run_metrics import ReviewedRun
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.what_if.rerun import Conditions
from passafe_services.tools.what_if.what_if import Question

EXTRA_S: Final = 0.15
SCENARIOS: Final = ("notomista-cai-2020", "walls-and-disks", "two-robots", "tight-limits")


@dataclass(frozen=True, kw_only=True)
class DelayPair:
    """Results of both runs of a pair.

    Attributes:
        scenario: Name of the scenario.
        recorded: Verdict of the run recorded under the delay.
        asked: Verdict of the what-if.
        h_apart: Difference of the smallest h.
        age_ms_apart: Difference of the median age of the state, ms.
        overridden_apart: Difference of the share of ticks in which the filter held something back.
        position_rms: Distance of the robots, root mean square.
    """

    scenario: str
    recorded: str
    asked: str
    h_apart: float
    age_ms_apart: float
    overridden_apart: float
    position_rms: float


def scenario_of(seed: int, extra_s: float, duration_s: float) -> Scenario:
    """Return the scenario of a pair: links and operator drawn by its seed, and the extra delay of the states."""
    draw = Random(seed)
    links: dict[str, Any] = {
        f"links.{name}": {
            "delay_s": draw.uniform(0.0, 0.04),
            "jitter_s": draw.uniform(0.0, 0.02),
            "loss": draw.uniform(0.0, 0.2),
            "seed": seed,
        }
        for name in ("operator-to-filter", "filter-to-plant", "plant-to-filter")
    }
    links["links.plant-to-filter"]["delay_s"] += extra_s
    name = SCENARIOS[seed % len(SCENARIOS)]
    return load_scenario(name, {"rate_hz": 200.0, "duration_s": duration_s, **links})


def record(path: Path, scenario: Scenario) -> RunLog:
    """Run a scenario in virtual time, and return its log."""
    metadata = run_metadata(scenario_json=scenario.model_dump_json(), versions={}, driver="lockstep")
    with LogWriter(path, metadata) as writer:
        loop = lockstep_loop(scenario, LockstepLog(writer))
        loop.run(steps_of(scenario) + round(EXTRA_S * scenario.rate_hz))
        loop.finish()
    return RunLog.read(path)


def delay_pair(seed: int, folder: Path, *, duration_s: float = 4.0) -> DelayPair:
    """Record a run, ask what it would have been under the delay, and record that one, too."""
    slow = scenario_of(seed, EXTRA_S, duration_s)
    question = Question.of(record(folder / "fast.mcap", scenario_of(seed, 0.0, duration_s)))
    question.answer(Conditions(scenario=slow), folder / "asked.mcap")
    recorded = ReviewedRun.of(record(folder / "slow.mcap", slow))
    asked = ReviewedRun.of(RunLog.read(folder / "asked.mcap"))
    [_, beside] = Comparison.of([recorded, asked]).runs
    differences, apart = beside.differences, beside.apart
    return DelayPair(
        scenario=slow.name,
        recorded=recorded.metrics.verdict,
        asked=asked.metrics.verdict,
        h_apart=differences["h_min"],
        age_ms_apart=differences["state_age_ms_p50"],
        overridden_apart=differences["overridden_share"],
        position_rms=float("nan") if apart is None else apart.rms,
    )
