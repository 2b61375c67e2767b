"""A decision in print: as a person reads it."""

import casadi as ca
import pytest

from passafe import (
    Barrier,
    Decision,
    FilterDesign,
    Linear,
    Mode,
    Passivity,
    SafetyPassivityFilter,
    Status,
    damped_point,
)


def decision(x: tuple[float, ...], *, barriers: bool = True) -> Decision:
    robot = damped_point(sigma=1.0)
    wall = Barrier(name="wall", h=1 - robot.position[0], class_k=(Linear(gain=5.0),) * 3)
    design = FilterDesign(
        system=robot.system,
        u_fb=-robot.velocity,
        fail_safe=robot.fail_safe,
        barriers=(wall,) if barriers else (),
        passivity=Passivity(V=ca.sumsqr(robot.velocity) / 2),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=50.0,
        mode=Mode.SAFE if barriers else Mode.OFF,
    )
    return SafetyPassivityFilter(design).decide(x=x, u=(0.0, 0.0), u_h=(20.0, 0.0), u_h_rate=(0.0, 0.0))


def test_decision_reads_as_a_person_would_say_it() -> None:
    made = decision((0.9, 0.0, 0.4, 0.0))
    head, u, barriers, power, solver = str(made).splitlines()

    assert head == "MODIFIED: changed so that every row is kept"
    assert u.startswith(f"  input     ({made.u[0]:.4g}, 0) (nominal (19.6, 0), operator (20, 0))")
    assert barriers == f"  barriers  lowest ψ {made.assessment.lowest_psi:.4g}"
    assert power == f"  power     margin {made.power_margin:.4g} W, slack 0 W"
    assert solver == f"  solver    {made.solver}"


def test_decision_without_barriers_says_so() -> None:
    text = str(decision((0.0, 0.0, 0.0, 0.0), barriers=False))

    assert text.startswith("PASSED: nothing stood in the way\n")
    assert "  barriers  none enforced\n" in text
    assert "slack 0 W" in text


def test_representation_is_one_line() -> None:
    made = decision((0.9, 0.0, 0.4, 0.0))

    assert repr(made) == f"Decision(status=MODIFIED, u={made.u}, solver={made.solver!r})"


@pytest.mark.parametrize("status", list(Status))
def test_every_outcome_is_explained(status: Status) -> None:
    made = decision((0.0, 0.0, 0.0, 0.0))
    fields = {name: getattr(made, name) for name in made.__struct_fields__}
    text = str(Decision(**fields | {"status": status}))

    assert text.splitlines()[0].startswith(f"{status.name}: ")
    assert text.splitlines()[0].endswith(": a fallback") == status.is_fallback
