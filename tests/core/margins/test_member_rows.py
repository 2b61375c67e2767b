"""Rows for sets: every member keeps ψ_{r−1} as the theory says, by brute force over members."""

from collections.abc import Callable, Mapping

import casadi as ca
import numpy as np
import pytest
from core_designs import drag_design, gains, paper_design, paper_passivity, pump_design
from uncertain_plants import INSTANTS, AnyMembers, Numbers

from passafe.barrier_chain import Barrier
from passafe.barriers import disk_keep_out, half_plane
from passafe.decision import Status
from passafe.design import FilterDesign, Mode
from passafe.filter import SafetyPassivityFilter
from passafe.models.lagged_point import lagged_point
from passafe.tank import Tank
from passafe.uncertainty import Uncertainty

MEMBERS = 30
GOOD = {Status.PASSED, Status.MODIFIED, Status.RELAXED}

TOGETHER = {
    "parameters": {"mass": (0.8, 1.3), "sigma": (0.7, 1.2)},
    "disturbance": (0.01, 0.02, 0.3, 0.4),
    "state_error": (2e-3, 1e-3, 2e-2, 1e-2),
    "input_error": (0.2, 0.3),
}


def point(**sets: object) -> FilterDesign:
    """Return the paper's robot at a slow rate, so that what happens between samples counts."""
    return paper_design(dt_s=0.02, k_i=20.0, mode=Mode.SAFE, uncertainty=Uncertainty(**sets))  # type: ignore[arg-type]  # sets by name


def drag(**_: object) -> FilterDesign:
    sets = Uncertainty(
        parameters={"mass": (0.9, 1.2), "drag": (0.5, 0.9)},
        disturbance=(0, 0, 0.3, 0.3),
        state_error=(1e-3, 1e-3, 1e-2, 1e-2),
    )
    return drag_design(dt_s=0.01, mode=Mode.SAFE, uncertainty=sets)


def lagged(**_: object) -> FilterDesign:
    """Return a robot of relative degree 3, whose mass and disturbance act before the input does."""
    robot = lagged_point(gamma_1=3.0, gamma_2=5.0)
    wall = half_plane(robot.position, normal=(0.6, 0.8), offset=-4.0)
    disk = disk_keep_out(robot.position, centre=(0.3, -0.2), radius=0.5)
    sets = Uncertainty(
        parameters={"mass": (0.9, 1.1), "lag_s": (0.04, 0.06), "sigma": (0.8, 1.2)},
        disturbance=(0, 0, 0.2, 0.2, 0, 0),
        state_error=(1e-3, 1e-3, 5e-3, 5e-3, 0.02, 0.02),
    )
    return paper_design(
        system=robot.system,
        u_fb=robot.proportional_derivative(k_p=1.0, k_d=1.0),
        fail_safe=robot.fail_safe,
        barriers=(
            Barrier(name="wall", h=wall, class_k=gains(3.0, 5.0, 8.0, 10.0)),
            Barrier(name="disk", h=disk, class_k=gains(3.0, 5.0, 8.0, 10.0)),
        ),
        mode=Mode.SAFE,
        passivity=paper_passivity(robot.system.x),
        dt_s=5e-3,
        k_i=20.0,
        uncertainty=sets,
    )


def pump(**_: object) -> FilterDesign:
    """Return a plant that is not affine in u."""
    return pump_design(
        mode=Mode.SAFE, uncertainty=Uncertainty(disturbance=(0.1, 0.1), state_error=(0.01, 0.01), input_error=(0.05, 0))
    )


PLANTS: Mapping[str, Callable[..., FilterDesign]] = {"drag": drag, "lagged": lagged, "pump": pump}


ALONE = ("parameters", "disturbance", "state_error", "input_error")


def design_named(name: str) -> FilterDesign:
    if name in PLANTS:
        return PLANTS[name]()
    return point(**(TOGETHER if name == "together" else {name: TOGETHER[name]}))


@pytest.mark.parametrize("name", [*ALONE, "together", *PLANTS])
def test_every_member_keeps_the_bound_between_samples(name: str) -> None:
    design = design_named(name)
    core, rng = SafetyPassivityFilter(design), np.random.default_rng(3)
    members, system = AnyMembers(design, MEMBERS, rng), design.system
    chains = list({chain.barrier.name.partition("[")[0]: chain for chain in core.chains}.values())
    last = ca.Function("p", [system.x], [ca.vertcat(*(c.psi[-2] for c in chains))]).map(MEMBERS)
    tight, zero = 0, [0.0] * members.m
    for x in near_the_boundary(core, rng, 15):
        towards = ca.Function("g", [system.x, system.u], [ca.gradient(chains[0].psi[-1], system.u)])
        push = towards(x, zero).full().ravel()
        u_h = (-0.2 * design.limits.high[0] * push / np.linalg.norm(push)).tolist()
        decision = core.decide(x.tolist(), zero, u_h, zero)
        if decision.status not in GOOD:
            continue
        tight += decision.status is Status.MODIFIED
        assert design.uncertainty is not None
        starts = members.starts(x.tolist(), design.uncertainty.state_error)
        path = [last(x_true).full() for x_true in members.follow(starts, decision.u, design.dt_s)]
        for k, p in enumerate(path):
            least = (1 - k / INSTANTS) * path[0] if name != "lagged" else 0 * p  # a lagged drive has another share
            assert np.where(path[0] >= 0, p - least, 0.0).min() >= -1e-9, (k, x)
    assert tight >= 3


@pytest.mark.parametrize("has_tank", [True, False])
def test_no_member_takes_more_energy_than_is_reported(has_tank: bool) -> None:
    """E − E_r, or without a tank the energy since the tick, falls by no more than the slack that is reported."""
    sets = Uncertainty(
        parameters={"mass": (0.8, 1.3), "sigma": (0.7, 1.2)},
        disturbance=(0, 0, 0.1, 0.1),
        state_error=(1e-4, 1e-4, 1e-3, 1e-3),
        input_error=(0.1, 0.1),
    )
    tank = Tank(initial_j=1.0, reserve_j=0.5) if has_tank else None
    base = paper_design()
    design = paper_design(
        system=base.system,
        u_fb=-base.system.x[2:],
        fail_safe=-base.system.x[2:],
        barriers=(),
        passivity=paper_passivity(base.system.x, tank=tank),
        dt_s=0.02,
        k_i=20.0,
        mode=Mode.PASSIVE,
        uncertainty=sets,
    )
    core, rng = SafetyPassivityFilter(design), np.random.default_rng(5)
    members, active = AnyMembers(design, MEMBERS, rng), 0
    for _ in range(15):
        x, u_h = rng.normal(size=4), rng.uniform(-20, 20, 2).tolist()
        decision = core.decide(x.tolist(), [0.0, 0.0], u_h, [0.0, 0.0], 0.55)
        assert decision.status in GOOD
        active += decision.status is not Status.PASSED
        path = members.follow(members.starts(x.tolist(), sets.state_error), decision.u, design.dt_s)
        for k, x_true in enumerate(path):
            supplied = np.array(decision.u) @ (x_true[:2] - path[0][:2])  # ∫yᵀu, for y is the position's rate
            stored = (x_true**2).sum(axis=0) - (path[0] ** 2).sum(axis=0)
            at_start = 0.05 * (1 - k / INSTANTS) if has_tank else 0.0
            least = at_start - (0.05 if has_tank else 0.0) - k / INSTANTS * design.dt_s * decision.slack
            assert (supplied - stored >= least - 1e-9).all(), (k, x)
    assert active >= 3


def near_the_boundary(core: SafetyPassivityFilter, rng: np.random.Generator, count: int) -> Numbers:
    """Return protected states with a small ψ, shape (count, n)."""
    x = core.design.system.x
    low = ca.Function("low", [x], [ca.mmin(ca.vertcat(*(p for c in core.chains for p in c.psi[:-1])))])
    drawn = rng.normal(size=(core.design.system.n, 4000)) * 1.5
    lows = low.map(4000)(drawn).full().ravel()
    protected = np.flatnonzero(lows > 0)
    return drawn[:, protected[np.argsort(lows[protected])[:count]]].T
