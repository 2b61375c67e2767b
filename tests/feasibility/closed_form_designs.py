"""Designs whose feasible sets are known in closed form."""

import casadi as ca

from passafe.barrier_chain import Barrier
from passafe.barriers import disk_keep_out
from passafe.class_k import Linear
from passafe.design import FilterDesign
from passafe.models.damped_point import damped_point
from passafe.passivity import Passivity
from passafe.system import System
from passafe.tank import Tank

GAIN = 2.0
TIGHTENING = 2e-6
"""By how much more than asked the filter keeps rows that have a margin between samples, units of u."""


def mass(*walls: tuple[tuple[float, ...], float], **changes: object) -> FilterDesign:
    """Return a unit mass without friction, p̈ = u, that stays where normalᵀp ≥ offset for each wall.

    Its rows are normalᵀu + 2γ normalᵀv + γ²(normalᵀp − offset) ≥ 0.
    """
    m = len(walls[0][0]) if walls else 1
    x, u = ca.SX.sym("x", 2 * m), ca.SX.sym("u", m)
    p, v = x[:m], x[m:]
    parts: dict[str, object] = {
        "system": System(x=x, u=u, f=ca.vertcat(v, u), y=v),
        "u_fb": ca.SX.zeros(m),
        "fail_safe": -v,
        "barriers": tuple(
            Barrier(name=f"wall {i}", h=ca.dot(ca.DM(list(normal)), p) - offset, class_k=(Linear(gain=GAIN),) * 3)
            for i, (normal, offset) in enumerate(walls)
        ),
        "passivity": Passivity(V=ca.sumsqr(v) / 2),
        "k_i": 10.0,
        "dt_s": 1e-3,
        "input_bound": 5.0,
        "between_samples": False,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types by name


def paper(*, gain: float, tank: Tank | None = None, **changes: object) -> FilterDesign:
    """Return the paper's robot, σ = 1, and disk, d = 1, with V = ‖x‖² and both gains of the chain the same."""
    robot = damped_point(sigma=1.0, gamma_1=gain)
    parts: dict[str, object] = {
        "system": robot.system,
        "u_fb": ca.SX.zeros(2),
        "fail_safe": robot.fail_safe,
        "barriers": (
            Barrier(
                name="disk",
                h=disk_keep_out(robot.position, centre=(0.0, 0.0), radius=1.0),
                class_k=(Linear(gain=gain),) * 3,
            ),
        ),
        "passivity": Passivity(V=ca.sumsqr(robot.system.x), tank=tank),
        "k_i": 10.0,
        "dt_s": 1e-3,
        "input_bound": 100.0,
        "between_samples": False,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types by name
