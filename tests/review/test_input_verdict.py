"""Verdicts on inputs: limits, rates, certificates."""

from pathlib import Path

import pytest
from damped_point_run import Run, rollout, scenario
from judged_runs import REST, coasting, judged
from passafe_protocol.messages import Certificate, FilterStatus, FilterTick, PlantInput


def test_an_input_beyond_the_bound_fails_where_it_was_sent(tmp_path: Path) -> None:
    run = coasting(Run(scenario(mode="off", input_bound=5.0)))
    run.replace(run.indices(PlantInput)[7], u=(0.0, -5.01))
    bounded = judged(run, tmp_path).properties["bounded"]
    assert (bounded.holds, bounded.worst, bounded.required) == (False, 5.01, True)
    assert bounded.at_s == pytest.approx(0.007)


@pytest.mark.parametrize(
    ("keys", "at", "beyond"),
    [
        ({"input_bound": [5.0, 3.0]}, (0.0, -3.5), 0.5),
        ({"input_low": -1.0}, (-1.25, 0.0), 0.25),
        ({"input_norm_bound": 4.0}, (3.0, 4.0), 1.0),
        ({"input_half_spaces": [{"weights": [3.0, 4.0], "bound": 10.0}]}, (2.0, 2.0), 0.8),
    ],
)
def test_an_input_beyond_one_of_many_limits_fails(
    tmp_path: Path, keys: dict[str, object], at: tuple[float, float], beyond: float
) -> None:
    run = coasting(Run(scenario(mode="off", **keys)))
    assert judged(run, tmp_path).properties["bounded"].holds
    run.replace(run.indices(PlantInput)[7], u=at)
    bounded = judged(run, tmp_path).properties["bounded"]
    assert (bounded.holds, bounded.worst) == (False, pytest.approx(beyond))
    assert bounded.requirement.startswith("input sent or applied beyond a limit by ≤ ")


def test_rates_are_judged_within_an_input_sequence(tmp_path: Path) -> None:
    limits = {"input_rate_low_per_s": -20.0, "input_rate_high_per_s": 10.0}
    run = coasting(Run(scenario(mode="off", **limits)))
    sent = run.indices(PlantInput)
    for k, place in enumerate(sent):
        run.replace(place, u=(0.009 * k, -0.019 * k), input_sequence_start_ns=0)
    assert judged(run, tmp_path).properties["bounded"].holds
    run.replace(sent[5], u=(0.06, -0.019 * 5))
    assert not judged(run, tmp_path).properties["bounded"].holds
    for place in sent[5:]:
        run.replace(place, input_sequence_start_ns=5_000_000)  # another sequence may begin with a jump
    run.replace(sent[6], u=(0.06, -0.019 * 6))
    assert judged(run, tmp_path).properties["bounded"].holds


def test_an_input_of_another_shape_is_beyond_every_bound(tmp_path: Path) -> None:
    run = coasting(Run(scenario(mode="off")))
    run.replace(run.indices(PlantInput)[7], u=(0.0, 0.0, 0.0))
    assert judged(run, tmp_path).properties["bounded"].worst == float("inf")


def test_u_norm_max_is_of_the_input_in_force(tmp_path: Path) -> None:
    run = Run(scenario(mode="off"))
    rollout(run, x0=(2.0, 0.0, 0.0, 0.0), u=lambda k: (3.0, 4.0) if k == 5 else REST, steps=10)
    verdict = judged(run, tmp_path)
    assert verdict.u_norm_max == pytest.approx(5.0)
    assert verdict.properties["bounded"].worst == 4.0


@pytest.mark.parametrize(
    ("certificate", "status", "holds"),
    [
        (Certificate("piqp", accepted=False, primal_residual=0, dual_residual=0, gap=0), "MODIFIED", False),
        (Certificate("piqp", accepted=True, primal_residual=2e-6, dual_residual=0, gap=0), "PASSED", False),
        (Certificate("piqp", accepted=True, primal_residual=0, dual_residual=0, gap=2e-6), "RELAXED", False),
        (Certificate("piqp", accepted=False, primal_residual=1, dual_residual=1, gap=1), "INFEASIBLE", True),
    ],
)
def test_an_answer_needs_a_certificate_and_a_fallback_does_not(
    tmp_path: Path, certificate: Certificate, status: str, *, holds: bool
) -> None:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: REST, steps=20)
    run.replace(run.indices(FilterTick)[5], certificate=certificate, status=FilterStatus[status])
    verdict = judged(run, tmp_path)
    certified = verdict.properties["certified"]
    assert certified.holds is holds
    assert certified.at_s == (None if holds else pytest.approx(0.005))
    assert verdict.properties["no-fallback"].holds is not holds
    assert verdict.verdict == "fails"
