"""Findings that the formulas of a design give before it decides anything."""

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from core_designs import drag_design, gains, jerk_design

from passafe.barrier_chain import Barrier, derive_chains
from passafe.barriers import half_plane
from passafe.checks.design_check import check_design, formula_findings
from passafe.checks.row_share import StateBox, row_findings
from passafe.checks.vanishing_effect import vanishing_effect
from passafe.design import FilterDesign, Mode
from passafe.errors import DesignError
from passafe.expressions.storage_sign import descent_of
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity, worst
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity
from passafe.storage import kinetic_energy
from passafe.system import System
from passafe.tank import Tank

x = ca.SX.sym("x", 2)


def walled(*, sigma: float = 1.0, hold_s: float = 0.0, bound: float = 20.0, tank: Tank | None = None) -> FilterDesign:
    robot = damped_point(sigma=sigma, gamma_1=5.0)
    return FilterDesign(
        system=robot.system,
        u_fb=0 * robot.velocity,
        fail_safe=robot.fail_safe,
        barriers=(
            Barrier(name="wall", h=half_plane(robot.position, normal=(-1.0, 0.0), offset=-1.0), class_k=gains(5, 5, 5)),
        ),
        passivity=Passivity(V=kinetic_energy(robot.velocity), tank=tank),
        k_i=50.0,
        dt_s=0.01,
        input_bound=bound,
        hold_s=hold_s,
    )


def findings(design: FilterDesign, x0: tuple[float, ...] | None = None) -> dict[str, Finding]:
    chains = [chain for barrier in design.barriers for chain in derive_chains(design.system, barrier)]
    return {one.topic: one for one in formula_findings(design, chains, x0)}


@pytest.mark.parametrize(("build", "degree"), [(drag_design, 2), (jerk_design, 3)])
def test_relative_degrees_are_named(build: Callable[[], FilterDesign], degree: int) -> None:
    found = findings(build())["relative degree"]

    assert found.severity is Severity.NOTE
    assert found.found.startswith(f"{degree}: the input appears in derivative {degree} of h")


def test_a_doubtful_relative_degree_is_a_warning() -> None:
    p, v, u = ca.SX.sym("p"), ca.SX.sym("v"), ca.SX.sym("u")
    system = System(x=ca.vertcat(p, v), u=u, f=ca.vertcat(v + 1e-5 * u, u), y=v)
    wall = Barrier(name="wall", h=1 - p, class_k=gains(5, 5))
    passivity = Passivity(V=v**2)
    none = ca.SX(0)
    design = replace(walled(), system=system, u_fb=none, fail_safe=none, barriers=(wall,), passivity=passivity)

    found = findings(design)["relative degree"]
    assert found.severity is Severity.WARNING
    assert "but 0.0001 times as strongly as in the next one" in found.found


@pytest.mark.parametrize(
    ("x0", "severity", "words"),
    [
        ((0.0, 0.0, 1.0, 0.0), Severity.NOTE, "ψ₀ = 1, ψ₁ = 4"),
        ((0.8, 0.0, 2.5, 0.0), Severity.WARNING, "ψ₀ = 0.2, ψ₁ = -1.5: ψ₁ < 0"),
        ((1.5, 0.0, -9.0, 0.0), Severity.WARNING, "h < 0"),
    ],
)
def test_a_start_outside_the_protected_set_is_named(x0: tuple[float, ...], severity: Severity, words: str) -> None:
    found = findings(walled(), x0)["start"]

    assert found.severity is severity
    assert words in found.found
    assert bool(found.advice) is (severity is Severity.WARNING)


def test_a_gain_too_high_for_the_hold_is_named() -> None:
    assert "loop rate" not in findings(walled())
    assert "5/s times the longest hold 0.4 s is 2" in findings(walled(hold_s=0.4))["loop rate"].found


def test_stiff_dynamics_are_named() -> None:
    assert findings(walled(sigma=50.0))["stiffness"].severity is Severity.NOTE
    stiff = findings(walled(sigma=9e3), (0.0,) * 4)["stiffness"]
    assert (stiff.severity, "is 90" in stiff.found) == (Severity.WARNING, True)


def test_dynamics_without_a_finite_slope_count_as_slow() -> None:
    p, v, u = ca.SX.sym("p"), ca.SX.sym("v"), ca.SX.sym("u")
    system = System(x=ca.vertcat(p, v), u=u, f=ca.vertcat(v, u + ca.sqrt(-1 - v**2)), y=v)
    design = replace(
        walled(), system=system, u_fb=ca.SX(0), fail_safe=ca.SX(0), barriers=(), passivity=Passivity(V=v**2)
    )

    assert "fastest rate 0/s" in findings(design)["stiffness"].found


@pytest.mark.parametrize(
    ("V", "falls"),
    [
        (x[1] ** 2, None),
        (ca.sumsqr(x) + 3 * x[0], None),
        ((1 + x[0] ** 2) * x[1] ** 2, None),
        (ca.SX(0) * x[0], None),
        (-(x[1] ** 2) / 2, (0, 1)),
        (x[0] * x[1], (1, -1)),
        (x[1] ** 2 + 9.81 * x[0], (-1, 0)),
        (x[1] ** 2 - x[0] ** 4, (1, 0)),
        (-ca.fabs(x[0]), (1, 0)),
        (x[0] ** 2 * x[1] ** 2 - x[1] ** 2 / 100, (0, 1)),
        (x[0] ** 2 - 1e-3 * x[1] ** 4 + x[1] ** 2, (0, 1)),
        (-ca.log(1 + x[0] ** 2), (1, 0)),
        (ca.sin(x[0]) + x[1] ** 2, None),
        (-(x[0] ** 2) / (1 + x[0] ** 2), None),
        (x[0] ** 4 - x[0] ** 2, None),
        (ca.sqrt(1 + x[0] ** 2) - x[0], None),
        (ca.fabs(x[0]) + x[1] ** 2, None),
        (ca.exp(x[0] ** 2) + ca.exp(x[1] ** 2), None),
    ],
)
def test_a_storage_without_a_lower_bound_falls_somewhere(V: ca.SX, falls: tuple[int, int] | None) -> None:
    descent = descent_of(V, x)

    assert (descent is None) is (falls is None)
    if descent is not None and falls is not None:
        along = abs(np.dot(descent.direction, falls)) / np.linalg.norm(falls)
        assert along > 0.5
        assert descent.values[-1] < descent.values[0] < 1
        assert "J at 100 times" in str(descent)


def test_a_falling_storage_is_refused_where_it_counts() -> None:
    design = walled()
    velocity = design.system.y
    bad = replace(design, passivity=Passivity(V=-ca.sumsqr(velocity) / 2), mode=Mode.SAFE)

    assert findings(design)["storage"].severity is Severity.NOTE
    assert findings(bad)["storage"].severity is Severity.WARNING
    for mode in (Mode.BOTH, Mode.PASSIVE):
        with pytest.raises(DesignError, match=r"passivity V: got V = -50 J at 10 .* times \(0, 0, -?1, 0\)"):
            replace(bad, mode=mode)


BOX = StateBox(x0=(0.0,) * 4, low=(-2.0,) * 4, high=(2.0,) * 4)


@pytest.mark.parametrize("tank", [None, Tank(initial_j=1.0, reserve_j=0.5, max_j=5.0, rate_per_s=5.0)])
def test_a_wall_alone_can_always_be_kept(tank: Tank | None) -> None:
    random, driven, energy, backup = row_findings(SafetyPassivityFilter(walled(tank=tank)), BOX, 40, 3)

    assert {found.severity for found in (random, driven, energy, backup)} == {Severity.NOTE}
    assert "of 40 in the protected set, rows can be kept with margins in 40, without in 40" in random.found
    assert driven.found.endswith("no fallback")


def test_a_drive_too_weak_for_its_gains_is_a_warning() -> None:
    box = replace(BOX, low=(-2.0, 0.0, 4.0, 0.0), high=(0.0, 0.0, 8.0, 0.0))
    random, *_ = row_findings(SafetyPassivityFilter(walled(bound=0.5)), box, 200, 3)

    assert random.severity is Severity.WARNING
    assert "passafe feasibility" in random.advice


def test_rows_that_can_never_be_kept_are_refused() -> None:
    box = StateBox(x0=(0.0, 0.0, 4.9, 0.0), low=(-0.1, 0.0, 4.9, 0.0), high=(-1e-3, 0.0, 5.0, 0.0))
    random, *_ = row_findings(SafetyPassivityFilter(walled(bound=0.05)), box, 40, 3)

    assert random.severity is Severity.REFUSED


def test_rows_need_not_be_kept_where_a_gatekeeper_is_backed() -> None:
    box = replace(BOX, low=(-2.0, 0.0, 4.0, 0.0), high=(0.0, 0.0, 8.0, 0.0))
    alone, *_ = row_findings(SafetyPassivityFilter(walled(bound=0.5)), box, 200, 3)
    guarded, *_ = row_findings(SafetyPassivityFilter(replace(walled(bound=0.5), gatekeeper=True)), box, 200, 3)

    assert alone.severity is Severity.WARNING
    assert guarded.severity is Severity.NOTE


def test_no_state_of_the_box_in_the_protected_set_is_said() -> None:
    box = replace(BOX, low=(2.0, 0.0, 0.0, 0.0), high=(3.0, 0.0, 0.0, 0.0))
    random, *_ = row_findings(SafetyPassivityFilter(walled()), box, 8, 3)

    assert random.found == "none of those drawn is in the protected set"


def test_the_worst_of_no_findings_is_a_note() -> None:
    one = Finding(severity=Severity.WARNING, topic="start", subject="barrier 'a'", found="ψ₁ = -1", advice="slower")

    assert worst(()) is Severity.NOTE
    assert worst((one, replace(one, severity=Severity.NOTE))) is Severity.WARNING
    assert str(one) == "start, barrier 'a': ψ₁ = -1; slower"
    assert str(replace(one, advice="")) == "start, barrier 'a': ψ₁ = -1"


def test_where_the_input_has_no_effect_on_a_row_is_said() -> None:
    p, v, u = ca.SX.sym("p"), ca.SX.sym("v"), ca.SX.sym("u")
    system = System(x=ca.vertcat(p, v), u=u, f=ca.vertcat(v, u), y=v)
    none = ca.SX(0)
    base = replace(walled(), system=system, u_fb=none, fail_safe=none, passivity=Passivity(V=v**2))
    box = StateBox(x0=(0.0, 0.5), low=(-2.0, -2.0), high=(2.0, 2.0))
    cases = {"kept": 4 - v**2, "lost": 1 - v**2 - p * v, "always": 3 - v}
    found = {}
    for name, h in cases.items():
        design = replace(base, barriers=(Barrier(name=name, h=h, class_k=gains(0.01, 1)),))
        said = check_design(SafetyPassivityFilter(design), box, samples=16)
        found[name] = [one for one in said if "vanishes" in one.found]

    assert [one.severity for one in found["kept"]] == [Severity.NOTE]
    assert "ψ is 0.04 there" in found["kept"][0].found
    assert [one.severity for one in found["lost"]] == [Severity.WARNING]
    assert found["always"] == []


def test_a_gradient_without_a_value_is_no_vanishing_effect() -> None:
    p, v, u = ca.SX.sym("p"), ca.SX.sym("v"), ca.SX.sym("u")
    system = System(x=ca.vertcat(p, v), u=u, f=ca.vertcat(v, u), y=v)
    none = ca.SX(0)
    wall = Barrier(name="log", h=ca.sqrt(3 - v), class_k=gains(1, 1))
    design = replace(walled(), system=system, u_fb=none, fail_safe=none, passivity=Passivity(V=v**2), barriers=(wall,))
    core = SafetyPassivityFilter(design)
    low, high = np.array([-30.0, -2.0]), np.array([-20.0, 9.0])

    assert vanishing_effect(design, core.chains[0], low, high, 1) is None
