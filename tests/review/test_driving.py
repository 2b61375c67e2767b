"""Tests of what comes first in a verdict: ticks in a fallback, and a robot that could not be driven."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from damped_point_run import PERIOD_NS, DampedPoint, Run, header, rollout, state
from passafe_protocol.messages import FilterStatus, FilterTick, Health, PlantPhase, PlantState
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.fallback_record import FallbackRecord
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.review.verdict_words import in_words

MS = 1_000_000
PASSED, STALE, INFEASIBLE = FilterStatus.PASSED, FilterStatus.STALE, FilterStatus.INFEASIBLE
AT_SAMPLES, BACKUP = FilterStatus.AT_SAMPLES, FilterStatus.BACKUP
REST = (0.0, 0.0)


def fallbacks(statuses: Sequence[FilterStatus]) -> Property:
    return FallbackRecord.of(zip(statuses, range(0, len(statuses) * MS, MS), strict=True), MS).property()


def drive(statuses: Sequence[FilterStatus], runs: Sequence[bool], period_ns: int = 100 * MS) -> Property:
    ticks, states = ([(one, k * period_ns) for k, one in enumerate(each)] for each in (statuses, runs))
    return DriveRecord.of(ticks, states).property()


def resting(tmp_path: Path, steps: int, **changes: Sequence[FilterStatus | PlantPhase]) -> Verdict:
    """Return the verdict on a robot that stops before the disk; ticks and states are changed in their order."""
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=steps)
    for field, body in (("status", FilterTick), ("phase", PlantState)):
        for index, value in zip(run.indices(body), changes.get(field, ()), strict=False):
            run.replace(index, **{field: value})
    return Verdict.of(RunLog.read(run.write(tmp_path / "run.mcap")), DampedPoint(), derives=False)


def test_a_stretch_ends_with_its_last_tick() -> None:
    found = fallbacks([PASSED, INFEASIBLE, PASSED, AT_SAMPLES, INFEASIBLE, AT_SAMPLES, PASSED, INFEASIBLE])

    assert (found.holds, found.worst, found.at_s) == (False, 5.0, 0.001)
    assert found.note == (
        "in a fallback in 5 of 8 ticks (62.50%: INFEASIBLE 3, AT_SAMPLES 2), first at 0.001 s, longest stretch 0.003 s"
    )


def test_a_fade_and_the_backup_law_are_no_fallbacks_of_a_review() -> None:
    assert fallbacks([PASSED, STALE, BACKUP, FilterStatus.RELAXED]).holds is True
    assert fallbacks([]).holds is None


def test_a_stretch_ends_where_a_restarted_plant_begins_anew() -> None:
    record = FallbackRecord.of([(INFEASIBLE, 500 * MS), (INFEASIBLE, 0), (INFEASIBLE, MS)], MS)

    assert record.property().note.endswith("longest stretch 0.002 s")


@pytest.mark.parametrize("status", [status for status in FilterStatus if status.is_fallback])
def test_a_filter_that_never_left_a_fallback_drove_nothing(status: FilterStatus) -> None:
    found = drive([status] * 5, [True] * 5)

    assert found.holds is False
    assert found.note == "the filter never left a fallback"
    assert drive([status] * 4 + [BACKUP], [True] * 5).holds is True


@pytest.mark.parametrize(("tail", "holds"), [(10, True), (11, False)])
def test_a_run_may_not_end_without_driving_for_a_second(tail: int, *, holds: bool) -> None:
    stale = drive([PASSED] * 30 + [STALE] * tail, [True] * 41)
    without = drive([PASSED] * 41, [True] * 30 + [False] * tail)

    assert (stale.holds, without.holds) == (holds, holds)
    assert stale.note == ("" if holds else "no fresh command came in the last 1.1 s")
    assert without.note == ("" if holds else "the robot stood without an input of the filter for the last 1.1 s")


def test_an_outage_within_a_run_takes_nothing_from_it() -> None:
    assert drive([PASSED] * 5 + [STALE] * 30 + [PASSED], [True] * 5 + [False] * 30 + [True]).holds is True


@pytest.mark.parametrize("size", [1, 7, 100])
def test_ticks_after_the_plant_has_ended_are_not_its_own(size: int) -> None:
    ticks = [(PASSED, 100 * k * MS) for k in range(50)] + [(STALE, 5000 * MS)] * 50
    one_by_one = DriveRecord.of(ticks, [(True, 0)])
    in_chunks = DriveRecord.of([], [(True, 0)])
    for k in range(0, len(ticks), size):
        status, at_ns = zip(*ticks[k : k + size], strict=True)
        in_chunks.add_ticks(np.array([one.value for one in status]), np.array(at_ns))
    outage = DriveRecord.of([*ticks, (PASSED, 5100 * MS)], [(True, 0)])

    assert one_by_one.property().note == in_chunks.property().note == ""
    assert outage.property().note == "the robot was without a fresh command for 50 % of the ticks"


def test_a_restarted_plant_has_to_be_driven_too() -> None:
    record = DriveRecord.of([(PASSED, 0)], [(True, 9000 * MS), (False, 0), (False, 1500 * MS)])

    assert record.property().holds is False


def test_fallback_ticks_fail_a_run_that_hits_nothing(tmp_path: Path) -> None:
    verdict = resting(tmp_path, 200, status=[PASSED] * 50 + [INFEASIBLE] * 20)

    assert verdict.properties["safe"].holds is True
    assert verdict.verdict == "fails"
    assert verdict.words.startswith("fails: in a fallback in 20 of 200 ticks (10.00%: INFEASIBLE 20), first at 0.050 s")


def test_all_ticks_in_a_fallback_are_said_before_anything_else(tmp_path: Path) -> None:
    verdict = resting(tmp_path, 100, status=[INFEASIBLE] * 100)

    assert verdict.words.startswith("fails: in a fallback in 100 of 100 ticks (100.00%")
    assert "the filter never left a fallback" in verdict.words


def test_a_robot_that_stands_to_the_end_does_not_hold(tmp_path: Path) -> None:
    verdict = resting(tmp_path, 1300, phase=[PlantPhase.RUNNING] * 200 + [PlantPhase.FAIL_SAFE] * 1100)

    assert verdict.verdict == "fails"
    assert verdict.words == "fails: the robot stood without an input of the filter for the last 1.1 s"


def test_a_robot_that_never_began_has_no_other_verdict(tmp_path: Path) -> None:
    verdict = resting(tmp_path, 50, phase=[PlantPhase.WAITING] * 50)

    assert verdict.verdict == "unproven"
    assert "the robot never had an input of the filter" in verdict.words


def test_of_two_plants_the_one_that_ended_last_counts(tmp_path: Path) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=3000)
    for index in run.indices(PlantState)[500:]:  # locked out by the other one
        run.replace(index, phase=PlantPhase.FAIL_SAFE)
    for k, runs in product(range(100), [PlantPhase.RUNNING]):
        run.add(header("plant", k, epoch=2, step=500 + k), state(k, (2.0, 0.0, 0.0, 0.0), REST, phase=runs))
    verdict = Verdict.of(RunLog.read(run.write(tmp_path / "two.mcap")), DampedPoint(), derives=False)

    assert verdict.sessions["plant"] == 2
    assert verdict.properties["driven"].note.endswith("for the last 2.5 s")


@pytest.mark.parametrize(
    ("source", "after_ms", "holds"), [("plant", 1001, False), ("plant", 1000, True), ("filter", 9000, True)]
)
def test_plant_that_went_on_without_a_state_was_not_driven(
    tmp_path: Path, source: str, after_ms: int, *, holds: bool
) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=100)
    last = run.sent[run.indices(PlantState)[-1]][0]
    seen = header(source, 0, step=round((last.sent_ns + after_ms * MS) / PERIOD_NS))
    run.add(seen, Health(1000.0, 100, 0, 0, 0.0, ()))
    verdict = Verdict.of(RunLog.read(run.write(tmp_path / "blind.mcap")), DampedPoint(), derives=False)

    assert verdict.properties["driven"].holds is holds
    assert ("the plant had no state of the robot for the last 1 s" in verdict.words) is not holds


@pytest.mark.parametrize(
    ("planned_s", "words"), [(None, "holds"), (0.101, "holds"), (0.102, "unproven"), (8.0, "unproven")]
)
def test_a_run_that_ended_before_its_time_is_not_whole(tmp_path: Path, planned_s: float | None, words: str) -> None:
    run = Run(planned_s=planned_s)
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=100)
    verdict = Verdict.of(RunLog.read(run.write(tmp_path / "run.mcap")), DampedPoint(), derives=False)
    said = (
        "" if planned_s is None or words == "holds" else f": not a whole run: it ended after 0.099 s of {planned_s} s"
    )

    assert verdict.words == words + said.replace("8.0", "8")


def test_words_name_what_is_unknown_and_what_was_not_asked() -> None:
    def entry(*, holds: bool | None, required: bool = True, **keys: object) -> Property:
        return Property.model_validate(
            {"holds": holds, "required": required, "worst": None, "at_s": None, "requirement": ""} | keys
        )

    assert in_words({"safe": entry(holds=True)}) == "holds"
    assert in_words({"safe": entry(holds=None), "bounded": entry(holds=True, note="from outside")}) == (
        "unproven: safe is unknown; from outside"
    )
    assert in_words({"safe": entry(holds=False, worst=-0.25, at_s=1.5, allowed="≥ 0")}) == (
        "fails: not safe: -0.25 at 1.500 s, allowed ≥ 0"
    )
    assert in_words({"complete": entry(holds=False, worst=2.0)}) == "unproven: not complete: 2"
    assert in_words({"safe": entry(holds=False, required=False)}) == "holds: violated but not required: safe"
