"""Runs single runs of a study, one after the other, and keeps what several of them share."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from time import perf_counter
from typing import Final, Generic, TypeVar

import numpy as np

from passafe.errors import DesignError, IntegrationError
from passafe_services.loop.lockstep import Lockstep, Observer
from passafe_services.operator.errors import RecordingError, SourceConfigError
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.scenarios.truth_schema import SwitchingDisturbance, TruthConfig
from passafe_services.simulation import CompiledScenario, lockstep_loop, steps_of
from passafe_services.tools.campaign.errors import NoSafeStartError
from passafe_services.tools.campaign.safe_starts import SafeStarts
from passafe_services.tools.experiment.cells import Run
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.metrics import Metrics, metrics_of
from passafe_services.tools.experiment.run_result import RunResult
from passafe_services.tools.experiment.run_trace import RunTrace
from passafe_services.tools.experiment.tracking import Motion, Tracking
from passafe_services.tools.review.core_evaluator import CoreEvaluator

MOST_COMPILED: Final = 32
MOST_REFERENCES: Final = 128
MOST_ROUNDS: Final = 8

EXPECTED: Final = (DesignError, IntegrationError, NoSafeStartError, RecordingError, ScenarioError, SourceConfigError)
"""Errors that a run may end with: a design that cannot be built, a plant that cannot be integrated, no safe start."""

_START: Final = 0x57A27
"""Second part of the seed of the generator of starts: others have the same first part."""

V = TypeVar("V")


class CompiledStudy:
    """All that is compiled from the plant and filter of a scenario.

    Attributes:
        compiled: For the nodes.
        evaluator: For the metrics.
        motion: For the tracking error.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.compiled = CompiledScenario.of(scenario)
        self.evaluator = CoreEvaluator(scenario)
        self.motion = Motion(self.compiled.model.robot)


class StudyRunner:
    """Runs single runs of a study; a run's metrics do not depend on what was run before it.

    Attributes:
        study: The study whose runs they are.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self._compiled: _Newest[CompiledStudy] = _Newest(MOST_COMPILED)
        self._starts: _Newest[SafeStarts] = _Newest(MOST_COMPILED)
        self._references: _Newest[Tracking] = _Newest(MOST_REFERENCES)

    def result(self, run: Run) -> RunResult:
        """Return the result of a run; an error that it may end with is part of the result."""
        begun_s = perf_counter()
        try:
            metrics, error = self.metrics(self.scenario_of(run)), ""
        except EXPECTED as refusal:
            metrics, error = None, " ".join(str(refusal).split())
        return RunResult(run=run, metrics=metrics, error=error, wall_s=perf_counter() - begun_s)

    def scenario_of(self, run: Run) -> Scenario:
        """Return everything that decides what a run does: any other driver can be given it.

        Raises:
            ScenarioError: A value that a scenario may not hold.
            NoSafeStartError: The box of starts has no safe one.
        """
        experiment = self.study.experiment
        overrides = experiment.overrides_of(run.variant, run.values)
        scenario = _seeded(self.study.scenario_with(overrides), run.seed, frozenset(overrides))
        if experiment.start == "scenario":
            return scenario
        # Modes differ in what they enforce, not in what there is to protect: all of them begin at the same states.
        both = scenario.model_copy(update={"filter": scenario.filter.model_copy(update={"mode": "both"})})
        box = (CompiledScenario.key_of(both), scenario.plant.start_low, scenario.plant.start_high)
        starts = self._starts.get(box, lambda: SafeStarts(both, self._compiled_for(both).compiled.filter.core))
        x0 = tuple(starts.draw(np.random.default_rng([run.seed, _START])).tolist())
        return scenario.model_copy(update={"plant": scenario.plant.model_copy(update={"x0": x0})})

    def trace(self, scenario: Scenario, observer: Observer | None = None) -> RunTrace:
        """Run a scenario and return the trace of the run.

        Args:
            scenario: As ``scenario_of`` gives it.
            observer: Called with every message, for a log.
        """
        compiled = self._compiled_for(scenario).compiled
        trace = RunTrace(compiled.filter.core, steered=isinstance(scenario.operator.source, HumanSource))
        loop = lockstep_loop(scenario, observer, taps=trace.taps, compiled=compiled)
        run_to_its_end(loop, trace, scenario)
        loop.finish()
        return trace

    def metrics(self, scenario: Scenario, *, until_its_end: bool = False) -> Metrics:
        """Run a scenario and return its metrics.

        Args:
            scenario: As ``scenario_of`` gives it.
            until_its_end: Leave out ticks for plant times beyond the duration, of which a live run has others.
        """
        compiled = self._compiled_for(scenario)
        trace = self.trace(scenario)
        if until_its_end:
            trace.forget_beyond(round(scenario.duration_s * 1e9))
        reference = self._reference(scenario, compiled) if self.study.experiment.tracking else None
        return metrics_of(scenario, trace, compiled.evaluator, compiled.motion, reference)

    def _compiled_for(self, scenario: Scenario) -> CompiledStudy:
        return self._compiled.get(CompiledScenario.key_of(scenario), lambda: CompiledStudy(scenario))

    def _reference(self, scenario: Scenario, compiled: CompiledStudy) -> Tracking:
        """Return where the robot of a scenario is without injected links."""
        clean = scenario.model_copy(update={"links": {}, "link_changes": ()})
        return self._references.get(clean.model_dump_json(), lambda: compiled.motion.of(self.trace(clean).trajectory()))


def run_to_its_end(loop: Lockstep, trace: RunTrace, scenario: Scenario) -> None:
    """Run a loop until plant time has reached the scenario's duration.

    Plant time begins when the first input arrives, and that takes as long as the links make it. A loop that gains no
    plant time in ``MOST_ROUNDS`` rounds in a row, of the length of the run each, is left as it is.
    """
    duration_ns, period_ns = round(scenario.duration_s * 1e9), round(1e9 / scenario.rate_hz)
    loop.run(steps_of(scenario))
    idle, reached_ns = 0, trace.plant_ns
    while reached_ns < duration_ns and idle < MOST_ROUNDS:
        loop.run(-(-(duration_ns - reached_ns) // period_ns))
        idle = 0 if trace.plant_ns > reached_ns else idle + 1
        reached_ns = trace.plant_ns
    loop.finish()


def _seeded(scenario: Scenario, seed: int, given: frozenset[str]) -> Scenario:
    """Return a scenario whose links, operator and truth have a seed, except where the experiment names one."""
    links = {
        name: link if f"links.{name}.seed" in given else link.model_copy(update={"seed": seed})
        for name, link in scenario.links.items()
    }
    operator, source = scenario.operator, scenario.operator.source
    if "seed" in type(source).model_fields and "operator.source.seed" not in given:
        operator = operator.model_copy(update={"source": source.model_copy(update={"seed": seed})})
    plant = scenario.plant
    if plant.truth is not None:
        plant = plant.model_copy(update={"truth": _seeded_truth(plant.truth, seed)})
    return scenario.model_copy(update={"links": links, "operator": operator, "plant": plant})


def _seeded_truth(truth: TruthConfig, seed: int) -> TruthConfig:
    """Return a truth whose disturbance and noise have a seed."""
    disturbance, noise = truth.disturbance, truth.noise
    if isinstance(disturbance, SwitchingDisturbance):
        disturbance = disturbance.model_copy(update={"seed": seed})
    if noise is not None:
        noise = noise.model_copy(update={"seed": seed})
    return truth.model_copy(update={"disturbance": disturbance, "noise": noise})


class _Newest(Generic[V]):
    """The values that were asked for last, by key."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._values: OrderedDict[Hashable, V] = OrderedDict()

    def get(self, key: Hashable, make: Callable[[], V]) -> V:
        """Return the value of a key, made if it is not there."""
        if key not in self._values:
            self._values[key] = make()
            if len(self._values) > self._most:
                self._values.popitem(last=False)
        self._values.move_to_end(key)
        return self._values[key]
