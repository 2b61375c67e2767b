"""Generated campaigns: a short, seeded slice of what ``make generated-campaign`` runs, and its results and summary."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from passafe_services.cli.app import app
from passafe_services.tools.generated.families import FAMILIES
from passafe_services.tools.generated.generated_job import LOOPS, GeneratedJob, generated_results, keeps_longer
from passafe_services.tools.generated.loop_result import LoopResult
from passafe_services.tools.generated.summary import GeneratedSummary
from typer.testing import CliRunner

SLICE = [LOOPS * design + loop for design in (0, 1, 2, 42, *range(4, 13), 3754) for loop in range(2)]
"""Loops of one design of every family, the stiff one of a kind that takes a second and not a minute, and of one more
that gets into a fallback."""


@cache
def slice_results() -> tuple[LoopResult, ...]:
    return tuple(GeneratedJob().compile()(SLICE))


def outcome(seed: int, **changes: object) -> LoopResult:
    parts: dict[str, object] = {
        "seed": seed,
        "family": "stable",
        "rate_hz": 100.0,
        "hold_s": 0.01,
        "oracle_share": 1.0,
        "started_inside": True,
        "operator": "switch",
        "ticks": 10,
        "statuses": {"PASSED": 8, "MODIFIED": 2},
        "h_start": 0.5,
        "h_min": 0.1,
        "psi_min": 0.1,
        "tank_min_j": 0.5,
        "tank_start_j": 1.0,
        "accounted_min_j": 0.2,
    }
    return LoopResult.model_validate(parts | changes)


def test_the_slice_has_every_family_and_no_input_beyond_limits() -> None:
    results = slice_results()

    assert [result.seed for result in results] == SLICE
    assert {result.family for result in results} == set(FAMILIES)
    for result in results:
        assert result.is_within_limits, result
        assert result.ticks == sum(result.statuses.values())


def test_without_a_fallback_h_and_tank_are_kept() -> None:
    kept = [
        result for result in slice_results() if result.started_inside and result.ticks and not result.fallback_ticks
    ]

    assert len(kept) > len(SLICE) / 4
    assert [result.seed for result in kept if not (result.is_safe and result.is_solvent)] == []


def test_accepted_designs_keep_h_and_tank_from_inside() -> None:
    counted = [result for result in slice_results() if result.counts]

    assert len(counted) > len(SLICE) / 3
    assert [result.seed for result in counted if not (result.is_safe and result.is_solvent)] == []


def test_braking_does_no_better_but_in_one_loop() -> None:
    """Seed 2 starts outside, three fallbacks, between which its operator drives on; the last falls 3 % deeper."""
    results = slice_results()

    assert sum(result.entries for result in results) > 4
    assert {result.seed for result in results if result.braking_better} <= {2}


def test_a_seed_decides_everything() -> None:
    again = GeneratedJob().compile()([SLICE[21], SLICE[5], SLICE[20]])

    assert again == [slice_results()[place] for place in (21, 5, 20)]


@pytest.mark.parametrize(
    ("braking", "filtered", "expected"),
    [
        ([1.0, 0.5, -0.1], [1.0, 0.2, 0.1], False),  # the filter keeps h: nothing is better
        ([1.0, 0.5, 0.4], [1.0, 0.2, -0.1], True),
        ([1.0, -0.1, -0.2], [1.0, 0.2, -0.3], False),  # braking fails first
        ([1.0, 0.5, -0.1], [1.0, -0.2, 0.1], True),  # later
        ([1.0, -0.1, -0.1], [1.0, -0.2, -0.1], True),  # as late, less deep
        ([1.0, -0.2, -0.1], [1.0, -0.2, -0.1], False),
    ],
)
def test_braking_is_better_only_where_h_is_lost(braking: list[float], filtered: list[float], *, expected: bool) -> None:
    assert keeps_longer(np.array(braking), np.array(filtered)) is expected


def test_the_summary_counts_each_failure_of_its_kind() -> None:
    summary = GeneratedSummary.of(
        [
            outcome(0),
            outcome(1, h_min=-1e-3, statuses={"INFEASIBLE": 10}, fallback_ticks=10, entries=1, braking_better=1),
            outcome(2, h_min=-1e-3),
            outcome(3, started_inside=False, h_min=-5.0),
            outcome(4, tank_min_j=-0.2, accounted_min_j=0.01),
            outcome(5, tank_min_j=-0.2, accounted_min_j=-0.01),
            outcome(6, overreach=1e-6),
            outcome(7, refusal="no"),
            outcome(8, warnings=("slow",), h_min=-1.0),
            outcome(9, gatekeeper=True, gatekeeper_advised=True),
        ]
    )
    family = summary.families[0]

    assert (family.loops, family.counted, family.safe, family.refused, family.warned) == (10, 7, 5, 1, 1)
    assert family.unsafe_seeds == (2, 1)  # without a fallback first
    assert family.unsafe_without_fallback == 1
    assert family.insolvent_seeds == (5,)
    assert family.beyond_limits_seeds == (6,)
    assert family.braking_better_seeds == (1,)
    assert family.fallback_share == pytest.approx(10 / 70)
    assert family.h_worst == -1e-3
    assert summary.accepted_share == pytest.approx(8 / 10)
    assert summary.as_drawn_share == pytest.approx(7 / 10)
    assert not family.holds
    assert GeneratedSummary.of([outcome(0)]).holds
    assert not GeneratedSummary.of([outcome(0), outcome(1, refusal="no")]).holds


def test_chunks_are_whole_designs() -> None:
    job = GeneratedJob()

    assert job.chunk_size(20_000, 2) == 5 * LOOPS
    assert job.chunk_size(16, 2) == LOOPS
    assert job.chunk_size(1, 1) == LOOPS


def test_a_generated_campaign_resumes_and_says_what_failed(tmp_path: Path) -> None:
    results = slice_results()
    list(generated_results(tmp_path / "generated.jsonl").add([list(results[:2]), list(results[2:4])]))
    options = ["campaign", "--generated", "--rollouts", "12", "--workers", "1", "--out", str(tmp_path)]
    done = CliRunner().invoke(app, options)

    assert set(generated_results(tmp_path / "generated.jsonl").results) == set(range(12))
    summary = GeneratedSummary.model_validate_json((tmp_path / "generated.summary.json").read_text(encoding="utf-8"))
    assert [family.loops for family in summary.families] == [8, 4]
    assert done.exit_code == (0 if summary.holds else 1)
    assert "accepted of the designs with a feasible oracle" in done.output


@pytest.mark.parametrize("arguments", [[], ["notomista-cai-2020", "--generated"]])
def test_scenarios_or_generated_not_both_or_neither(arguments: list[str], tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["campaign", *arguments, "--out", str(tmp_path)])

    assert done.exit_code != 0
    assert "scenarios, or --generated" in done.output + str(done.exception)
