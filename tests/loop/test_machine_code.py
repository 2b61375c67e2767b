"""Machine code by the C compiler: the same numbers to the last bit, or the function as it was."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from passafe_services.loop import machine_code as module
from passafe_services.loop.machine_code import machine_code
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.load import load_scenario

from passafe import SafetyPassivityFilter

STATES = np.random.default_rng(0).normal(scale=3.0, size=(2, 500))


def swing(name: str) -> ca.Function:
    """Return steps of a pendulum, with all that rounds: sums of products, roots, waves, selections."""
    x = ca.SX.sym("x", 2)
    pull = ca.if_else(x[0] > 1, ca.sqrt(ca.fabs(x[0])), ca.exp(-(x[0] ** 2)))
    after = x + 0.1 * ca.vertcat(x[1], ca.sin(x[0]) - 0.3 * x[1] + pull / 7 + ca.tanh(x[1]) * ca.atan2(x[1], x[0]))
    return ca.Function(name, [x], [after]).mapaccum(name, 50)


@pytest.fixture(autouse=True)
def _forget() -> None:
    module._compiled.cache_clear()


def test_compiled_numbers_are_the_same_to_the_last_bit() -> None:
    plain = swing("swing")
    compiled = machine_code(plain)

    assert compiled.is_a("External")
    for state in STATES.T:
        assert np.array_equal(plain(state).full(), compiled(state).full(), equal_nan=True)


def test_decisions_with_a_gatekeeper_are_the_same() -> None:
    scenario = load_scenario("walls-and-disks", {"filter.gatekeeper": True})
    design = design_of(scenario, robot_of(scenario))
    plain, compiled = SafetyPassivityFilter(design), SafetyPassivityFilter(design, compiler=machine_code)
    rng = np.random.default_rng(1)

    assert plain.rollout is not None
    for _ in range(20):
        request = [rng.normal(size=4).tolist(), *([rng.normal(size=2).tolist()] * 2), [0.0, 0.0]]
        assert plain.decide(*request).u == compiled.decide(*request).u


def test_equal_functions_are_compiled_once() -> None:
    machine_code(swing("swing"))
    machine_code(swing("swing"))

    assert module._compiled.cache_info().hits == 1


def test_without_a_compiler_a_function_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "which", lambda _command: None)
    plain = swing("swing")

    assert machine_code(plain) is plain


@pytest.mark.parametrize("script", ["exit 1", "exit 0", "sleep 10"], ids=["fails", "makes nothing", "hangs"])
def test_a_broken_compiler_leaves_a_function_as_it_is(
    script: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler = tmp_path / "cc"
    compiler.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    compiler.chmod(0o755)
    monkeypatch.setattr(module, "which", lambda _command: str(compiler))
    monkeypatch.setattr(module, "LONGEST_S", 0.5)
    plain = swing("swing")

    assert machine_code(plain) is plain
