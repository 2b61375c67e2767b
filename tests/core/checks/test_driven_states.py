"""Operators that drive from the start: a double integrator, |u| ≤ 1, that must stay left of 1."""

from dataclasses import replace

import casadi as ca
import pytest

from passafe.barrier_chain import Barrier
from passafe.checks.backup_start import backup_findings, is_kept_from
from passafe.checks.driven_states import driven_findings
from passafe.class_k import Linear
from passafe.design import FilterDesign, Law, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Severity
from passafe.passivity import Passivity
from passafe.system import System
from passafe.tank import Tank

DT_S = 0.01


def walled(gain: float, **changes: object) -> FilterDesign:
    """Return ẍ = u, |u| ≤ 1, which stays left of 1; the fail-safe law brakes fully down to 1/50 m/s."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u")
    design = FilterDesign(
        system=System(x=x, u=u, f=ca.vertcat(x[1], u), y=x[1]),
        u_fb=ca.SX(0),
        fail_safe=-50 * x[1],
        barriers=(Barrier(name="wall", h=1 - x[0], class_k=(Linear(gain=gain),) * 3),),
        passivity=Passivity(V=x[1] ** 2 / 2),
        k_i=1.0,
        dt_s=DT_S,
        input_bound=1.0,
        mode=Mode.SAFE,
    )
    return replace(design, **changes)  # type: ignore[arg-type]  # by name


def test_low_gains_leave_operators_without_a_fallback() -> None:
    """With γ = 0.5/s rows ask for −γ²h − 2γv, at most 1 from rest 1 m away."""
    (found,) = driven_findings(SafetyPassivityFilter(walled(0.5)), (0.0, 0.0), 40, 1)

    assert found.severity is Severity.NOTE
    assert found.found == "8 operators drove from the start at the limits of the input for 3 s: no fallback"


def test_high_gains_let_operators_reach_a_fallback() -> None:
    """With γ = 20/s rows let it race up to where full braking is too late: v²/2 > h."""
    (found,) = driven_findings(SafetyPassivityFilter(walled(20.0)), (0.0, 0.0), 40, 1)

    assert found.severity is Severity.WARNING
    assert "of them into a fallback, first INFEASIBLE after 1.32 s at (0.871, 1.32)" in found.found
    assert "gatekeeper" in found.advice


def pushed(tank: Tank | None, growth: float = 1.0) -> SafetyPassivityFilter:
    """Return ẍ = growth·ẋ + u before a wall that comes with 1 m/s: with V = ẋ²/2 it gives out growth·ẋ²."""
    x, u, t = ca.SX.sym("x", 2), ca.SX.sym("u"), ca.SX.sym("t")
    system = System(x=x, u=u, f=ca.vertcat(x[1], growth * x[1] + u), y=x[1], t=t)
    wall = Barrier(name="wall", h=x[0] - t, class_k=(Linear(gain=2.0),) * 3)
    passivity = Passivity(V=x[1] ** 2 / 2, tank=tank)
    changes = {"system": system, "fail_safe": -50 * x[1], "barriers": (wall,), "passivity": passivity}
    return SafetyPassivityFilter(walled(2.0, **changes, mode=Mode.BOTH, input_bound=10.0))


def test_a_tank_that_safety_empties_warns() -> None:
    """A joule lasts a second before the wall; the robot starts with the wall's speed, 0.1 m ahead."""
    (rows, energy) = driven_findings(pushed(Tank(initial_j=1.0, reserve_j=0.5)), (0.1, 1.0), 40, 1)

    assert rows.severity is Severity.NOTE
    assert (energy.severity, energy.topic) == (Severity.WARNING, "energy")
    least_j, below_s = (float(part.split()[0]) for part in energy.found.split("tank ")[1].split("after "))
    assert least_j < 0 < below_s
    assert "a larger tank" in energy.advice


def test_a_tank_that_lasts_is_a_note() -> None:
    """A plant that dissipates needs none of it: braking before the wall fills it."""
    (_, energy) = driven_findings(pushed(Tank(initial_j=1.0, reserve_j=0.5), growth=-1.0), (0.1, 1.0), 40, 1)

    assert energy.severity is Severity.NOTE
    assert "relaxed in 0% of the periods, least energy in the tank" in energy.found


def test_without_a_tank_the_share_of_slack_is_reported() -> None:
    (_, energy) = driven_findings(pushed(None), (0.1, 1.0), 40, 1)

    assert energy.severity is Severity.NOTE
    assert energy.found.endswith("% of the periods")


@pytest.mark.parametrize(("hold_s", "warns"), [(0.1, False), (0.4, True)])
def test_a_law_that_was_sent_and_may_be_held_too_long_warns(hold_s: float, *, warns: bool) -> None:
    """Sent every 0.1 s −8·v settles, held for 0.4 s it swings ever further; 3 cm before the wall it brakes better."""
    design = walled(2.0, dt_s=0.1, hold_s=hold_s, input_bound=30.0)
    core = SafetyPassivityFilter(replace(design, fail_safe=-8 * design.system.x[1]))
    found = driven_findings(core, (0.97, 0.256), 40, 1, 2)

    assert [each.severity for each in found] == [Severity.NOTE, *[Severity.WARNING] * warns]
    assert all(each.topic == "fail-safe" and "held for 0.4 s at a time" in each.found for each in found[1:])


def test_slow_loops_are_driven_for_fifty_periods_at_least() -> None:
    (found,) = driven_findings(SafetyPassivityFilter(walled(0.1, dt_s=0.5)), (0.0, 0.0), 40, 1, 2)

    assert found.found.startswith("2 operators drove from the start at the limits of the input for 25 s")


def test_a_gatekeeper_has_no_fallback_where_the_law_keeps_all() -> None:
    """Backed states may be outside of the protected set, where no input keeps the rows: that is no fallback either."""
    core = SafetyPassivityFilter(walled(20.0, gatekeeper=True))

    assert is_kept_from(core, (0.0, 0.0))
    (driven,) = driven_findings(core, (0.0, 0.0), 40, 1)
    assert driven.severity is Severity.NOTE
    (found,) = backup_findings(core, (0.0, 0.0))
    assert found.severity is Severity.NOTE
    assert found.found == "keeps every barrier until the robot rests, h ≥ 1: a gatekeeper would do so for ever"


def test_a_robot_that_the_backup_law_mostly_brakes_warns() -> None:
    """Gains of 20/s over periods of 0.1 s leave no margin: the rows are hardly ever kept between samples."""
    (found,) = driven_findings(SafetyPassivityFilter(walled(20.0, dt_s=0.1, gatekeeper=True)), (0.0, 0.0), 40, 1, 2)

    assert found.severity is Severity.WARNING
    assert found.found.endswith("for 5 s: the backup law braked in 96% of the periods")
    assert "gatekeeper" not in found.advice


def test_too_fast_a_start_leaves_a_gatekeeper_helpless() -> None:
    """From 2 m/s it takes 2 m to stop: h = −1 after 2 s."""
    core = SafetyPassivityFilter(walled(20.0, gatekeeper=True))

    assert not is_kept_from(core, (0.0, 2.0))
    (found,) = backup_findings(core, (0.0, 2.0))
    assert found.severity is Severity.WARNING
    assert found.found.startswith("h is -1 after 2.")
    assert found.advice.startswith("the gatekeeper does nothing from here")
    (alone,) = backup_findings(SafetyPassivityFilter(walled(20.0)), (0.0, 2.0))
    assert alone.severity is Severity.NOTE
    assert alone.advice == ""


def test_a_law_that_coasts_away_keeps_all_for_ever() -> None:
    core = SafetyPassivityFilter(walled(1.0, fail_safe=ca.SX(0)))

    assert is_kept_from(core, (0.0, -1.0))


def test_a_law_that_swings_never_comes_to_rest() -> None:
    design = walled(1.0)
    core = SafetyPassivityFilter(replace(design, fail_safe=-design.system.x[0] - 0.005 * design.system.x[1]))

    (found,) = backup_findings(core, (0.0, -0.5))
    assert found.found == "keeps every barrier for 20.5 s, in which the robot does not come to rest"


def test_a_step_that_is_too_long_proves_nothing() -> None:
    """Coasts to rest with v̇ = −4·sin v in periods of half a second, over which no estimate of the step is small."""
    design = walled(1.0, dt_s=0.5, fail_safe=ca.SX(0))
    x, u = design.system.x, design.system.u
    damped = replace(design.system, f=ca.vertcat(x[1], u - 4 * ca.sin(x[1])))
    core = SafetyPassivityFilter(replace(design, system=damped))

    (found,) = backup_findings(core, (0.0, 0.5))
    assert found.found == "h ≥ 0 at every sample, but not known to be between them"


@pytest.mark.parametrize("changes", [{"barriers": ()}, {"law": Law.CONTINUOUS}])
def test_nothing_is_said_where_the_law_keeps_no_barrier(changes: dict[str, object]) -> None:
    core = SafetyPassivityFilter(walled(1.0, **changes))

    assert list(backup_findings(core, (0.0, 0.0))) == []
    assert not is_kept_from(core, (0.0, 0.0))


@pytest.mark.parametrize("gatekeeper", [False, True])
def test_rows_that_no_input_keeps_are_no_fallback_when_guarded(*, gatekeeper: bool) -> None:
    """At 0.4 m from the wall with 0.8 m/s it stops in time (0.32 m), but ψ₁ = 0.5·0.4 − 0.8 < 0 cannot rise by 5·ψ₁."""
    gains = (Linear(gain=0.5), Linear(gain=5.0), Linear(gain=5.0))
    design = walled(1.0, gatekeeper=gatekeeper)
    design = replace(design, barriers=(replace(design.barriers[0], class_k=gains),))
    decision = SafetyPassivityFilter(design).decide((0.6, 0.8), (-1.0,), (1.0,), (0.0,))

    assert decision.status.name == ("BACKUP" if gatekeeper else "INFEASIBLE")
    assert decision.u == pytest.approx((-1.0,))
