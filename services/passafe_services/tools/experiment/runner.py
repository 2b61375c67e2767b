"""Runs single runs of a study, one after the other, and keeps what several of them share."""

from collections import OrderedDict
from collections.abc import Callable, Hashable
from time import perf_counter
from typing import Final, Generic, TypeVar

import numpy as np
from pydantic import BaseModel

from passafe.errors import DesignError, IntegrationError
from passafe_services.loop.lockstep import Lockstep, Observer
from passafe_services.operator.errors import RecordingError, SourceConfigError
from passafe_services.scenarios.errors import ScenarioError
from passafe_services.scenarios.schema import Scenario
from passafe_services.scenarios.source_schema import HumanSource
from passafe_services.simulation import CompiledScenario, lockstep_loop, steps_of
from passafe_services.tools.campaign.errors import NoSafeStartError
from passafe_services.tools.campaign.safe_starts import SafeStarts
from passafe_services.tools.experiment.load import Study
from passafe_services.tools.experiment.metrics import Metrics, metrics_of
from passafe_services.tools.experiment.run_trace import RunTrace
from passafe_services.tools.experiment.runs import Result, Run
from passafe_services.tools.experiment.tracking import Motion, Tracking
from passafe_services.tools.review.core_evaluator import CoreEvaluator

MOST_DERIVED: Final = 32
MOST_REFERENCES: Final = 128
MOST_ROUNDS: Final = 8

EXPECTED: Final = (DesignError, IntegrationError, NoSafeStartError, RecordingError, ScenarioError, SourceConfigError)
"""What a run may end with: a design that cannot be built, a plant that cannot be integrated, no safe start."""

_START: Final = 0x57A27
"""Tells the generator of starts from others with the same seed."""

V = TypeVar("V")


class CompiledStudy:
    """What is compiled from the plant and filter of a scenario.

    Attributes:
        compiled: For the nodes.
        evaluator: For the figures.
        motion: For the tracking error.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.compiled = CompiledScenario.of(scenario)
        self.evaluator = CoreEvaluator(scenario)
        self.motion = Motion(self.compiled.model.robot)


class StudyRunner:
    """Runs what it is asked for; a run's figures do not depend on what was run before it.

    Attributes:
        study: The study whose runs they are.
    """

    def __init__(self, study: Study) -> None:
        self.study = study
        self._kits: _Newest[CompiledStudy] = _Newest(MOST_DERIVED)
        self._starts: _Newest[SafeStarts] = _Newest(MOST_DERIVED)
        self._references: _Newest[Tracking] = _Newest(MOST_REFERENCES)

    def result(self, run: Run) -> Result:
        """Return what a run comes to; what it may fail with is told in the result."""
        begun_s = perf_counter()
        try:
            figures, error = self.figures(self.scenario_of(run)), ""
        except EXPECTED as refusal:
            figures, error = None, " ".join(str(refusal).split())
        return Result(run=run, figures=figures, error=error, wall_s=perf_counter() - begun_s)

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
        starts = self._starts.get(box, lambda: SafeStarts(both, self._kit(both).compiled.filter.core))
        x0 = tuple(starts.draw(np.random.default_rng([run.seed, _START])).tolist())
        return scenario.model_copy(update={"plant": scenario.plant.model_copy(update={"x0": x0})})

    def play(self, scenario: Scenario, observer: Observer | None = None) -> RunTrace:
        """Run a scenario and return what was kept of it.

        Args:
            scenario: As ``scenario_of`` gives it.
            observer: Called with every message, for a log.
        """
        compiled = self._kit(scenario).compiled
        tape = RunTrace(compiled.filter.core, steered=isinstance(scenario.operator.source, HumanSource))
        loop = lockstep_loop(scenario, observer, taps=tape.taps, compiled=compiled)
        run_to_its_end(loop, tape, scenario)
        loop.finish()
        return tape

    def figures(self, scenario: Scenario, *, until_its_end: bool = False) -> Metrics:
        """Run a scenario and return its figures.

        Args:
            scenario: As ``scenario_of`` gives it.
            until_its_end: Leave out ticks for plant times beyond the duration, of which a live run has others.
        """
        kit = self._kit(scenario)
        tape = self.play(scenario)
        if until_its_end:
            tape.forget_beyond(round(scenario.duration_s * 1e9))
        reference = self._reference(scenario, kit) if self.study.experiment.tracking else None
        return metrics_of(scenario, tape, kit.evaluator, kit.motion, reference)

    def _kit(self, scenario: Scenario) -> CompiledStudy:
        return self._kits.get(CompiledScenario.key_of(scenario), lambda: CompiledStudy(scenario))

    def _reference(self, scenario: Scenario, kit: CompiledStudy) -> Tracking:
        """Return where the robot of a scenario is without injected links."""
        clean = scenario.model_copy(update={"links": {}, "link_changes": ()})
        return self._references.get(clean.model_dump_json(), lambda: kit.motion.of(self.play(clean).trajectory()))


def run_to_its_end(loop: Lockstep, tape: RunTrace, scenario: Scenario) -> None:
    """Run a loop until plant time has reached the scenario's duration.

    Plant time begins when the first input arrives, and that takes as long as the links make it. A loop that gains no
    plant time in ``MOST_ROUNDS`` rounds in a row, of the length of the run each, is left as it is.
    """
    duration_ns, period_ns = round(scenario.duration_s * 1e9), round(1e9 / scenario.rate_hz)
    loop.run(steps_of(scenario))
    idle, reached_ns = 0, tape.plant_ns
    while reached_ns < duration_ns and idle < MOST_ROUNDS:
        loop.run(-(-(duration_ns - reached_ns) // period_ns))
        idle = 0 if tape.plant_ns > reached_ns else idle + 1
        reached_ns = tape.plant_ns
    loop.finish()


def _seeded(scenario: Scenario, seed: int, given: frozenset[str]) -> Scenario:
    """Return a scenario whose links and operator have a seed, except where the experiment names one."""
    links = {
        name: link if f"links.{name}.seed" in given else link.model_copy(update={"seed": seed})
        for name, link in scenario.links.items()
    }
    operator, source = scenario.operator, scenario.operator.source
    if "seed" in type(source).model_fields and "operator.source.seed" not in given:
        operator = operator.model_copy(update={"source": _with_seed(source, seed)})
    return scenario.model_copy(update={"links": links, "operator": operator})


def _with_seed(source: BaseModel, seed: int) -> BaseModel:
    return source.model_copy(update={"seed": seed})


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
