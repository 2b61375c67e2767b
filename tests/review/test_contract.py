"""Contracts of logs: what they add to a verdict, and what they refuse."""

from pathlib import Path

import pytest
from damped_point_run import DampedPoint, Run, rollout
from junitparser import JUnitXml
from passafe_services.cli.junit import write_junit
from passafe_services.tools.review.contract import ContractError, LogContract, TopicContract, load_contract, under
from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.verdict import Verdict

EXAMPLE = Path(__file__).parents[2] / "examples" / "contract.toml"


@pytest.fixture
def verdict(tmp_path: Path) -> Verdict:
    run = Run()
    rollout(run, x0=(2.0, 0.0, -0.5, 0.0), u=lambda _: (0.0, 0.0), steps=201)
    return Verdict.of(RunLog.read(run.write(tmp_path / "run.mcap")), DampedPoint(), derives=False)


def test_bounds_that_are_kept_change_nothing(verdict: Verdict) -> None:
    kept = LogContract(h_min_at_least=0.5, topics={"state": TopicContract(rate_hz_at_least=1000, gaps_at_most=0)})

    assert under(verdict, kept).verdict == "holds"
    assert {name for name in under(verdict, kept).properties if "contract" in name} == {
        "contract: h_min",
        "contract: state.rate_hz",
        "contract: state.gaps",
    }


@pytest.mark.parametrize(
    ("asked", "name", "outcome"),
    [
        (LogContract(h_min_at_least=3.0), "h_min", "fails"),
        (LogContract(duration_s_at_least=0.201), "duration_s", "fails"),
        (LogContract(topics={"command": TopicContract(rate_hz_at_most=1004)}), "command.rate_hz", "fails"),
        (LogContract(late_us_p99_at_most=0.0), "late_us_p99", "holds"),
    ],
)
def test_a_bound_is_a_required_property(verdict: Verdict, asked: LogContract, name: str, outcome: str) -> None:
    found = under(verdict, asked)

    assert found.properties[f"contract: {name}"].required
    assert found.verdict == outcome
    assert (name in found.words) is (outcome == "fails")


def test_what_the_log_does_not_show_is_unproven(verdict: Verdict) -> None:
    asked = LogContract(solve_us_p99_at_most=1e9)
    found = under(verdict.model_copy(update={"solve_us_p99": None}), asked)

    assert found.properties["contract: solve_us_p99"].holds is None
    assert found.verdict == "unproven"


def test_a_property_can_be_required(verdict: Verdict) -> None:
    entry = verdict.properties["protected-start"]
    assert not entry.required

    assert under(verdict, LogContract(require=("protected-start",))).properties["protected-start"].required


def test_a_property_that_the_run_does_not_have_is_unproven(verdict: Verdict) -> None:
    assert "model" not in verdict.properties
    found = under(verdict, LogContract(require=("model",)))

    assert found.verdict == "unproven"
    assert "model was required" in found.words


def test_the_example_is_a_contract() -> None:
    assert load_contract(EXAMPLE).topics["state"].gaps_at_most == 0


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("h_min_at_lest = 1", ("h_min_at_lest", "did you mean h_min_at_least")),
        ("require = ['saef']", ("saef", "did you mean safe")),
        ("[topics.stat]", ("stat", "did you mean state")),
        ("[topics.state]\ngaps_at_most = -1", ("topics.state.gaps_at_most", "-1")),
        ("x =", ("readable TOML",)),
    ],
)
def test_a_contract_that_is_none_is_refused(text: str, parts: tuple[str, ...], tmp_path: Path) -> None:
    path = tmp_path / "contract.toml"
    path.write_text(text)

    with pytest.raises(ContractError) as caught:
        load_contract(path)
    assert all(part in str(caught.value) for part in (*parts, "contract.toml"))


def test_junit_has_a_case_for_each_property(verdict: Verdict, tmp_path: Path) -> None:
    asked = LogContract(h_min_at_least=3.0, solve_us_p99_at_most=1.0)
    write_junit(tmp_path / "review.xml", under(verdict.model_copy(update={"solve_us_p99": None}), asked), Path("a"))

    [suite] = JUnitXml.fromfile(str(tmp_path / "review.xml"))
    kinds = {case.name: [type(result).__name__ for result in case.result] for case in suite}
    assert kinds["contract: h_min"] == ["Failure"]
    assert kinds["contract: solve_us_p99"] == ["Error"]
    assert kinds["safe"] == []
    assert (suite.failures, suite.errors) == (1, 1)
