"""A car with the kinematics of a unicycle, driven by its nose: a heading that barriers depend on."""

import casadi as ca

from passafe.arguments.ranges import require_positive
from passafe.models.braking import braking_condition, stopping_segment
from passafe.models.drawing import Drawing
from passafe.models.fail_safe_scope import FailSafeScope
from passafe.models.robot import Robot
from passafe.models.task_frame import TaskFrame
from passafe.parameter import Parameter
from passafe.system import System

_OUTLINE = ((1.0, 0.0), (0.55, 0.45), (-0.7, 0.45), (-0.7, -0.45), (0.55, -0.45))
"""Corners of the car in lengths of its nose."""


def unicycle(*, drag: float = 1.0, nose_m: float = 0.3, brake_per_s: float = 5.0) -> Robot:
    """Return ṗ = v(cos θ, sin θ), θ̇ = ω, v̇ = −dv + u₁, ω̇ = −dω + u₂, x = (p, θ, v, ω).

    The position is that of the nose, q = p + ℓ(cos θ, sin θ), which no direction is closed to: q̈ = R(θ)(u₁ − dv − ℓω²,
    ℓ(u₂ − dω) + vω), R the rotation. So positions have relative degree 2 in every heading, where p alone would answer
    the steering only through its speed. A nose that keeps r + ℓ away from a place keeps p at r.

    The car's radius of gyration is ℓ: V = ½(v² + ℓ²ω²) = ½‖q̇‖², y = (v, ℓ²ω), V̇ = yᵀu − 2dV. The feedback (ℓω²,
    −vω/ℓ) takes the turning out of q̈ and supplies no power, ℓω²v − ℓ²ωvω/ℓ = 0. Commands are forces on the nose in the
    world's frame, u_h = (wᵀe₁, wᵀe₂/ℓ), e₁ forward and e₂ left: q̈ = w − dq̇ with that feedback.

    The fail-safe gives q̈ = −κq̇, so that the nose stops on the straight segment to q + q̇/κ, with what
    ``passafe.models.braking`` says of it, if it is followed at every instant.

    Args:
        drag: d, 1/s, positive: a parameter that may turn out otherwise.
        nose_m: ℓ, m, positive.
        brake_per_s: κ, 1/s, positive.

    Raises:
        DesignError: Numbers that make no such robot.
    """
    require_positive("unicycle drag", drag, "1/s")
    require_positive("unicycle nose_m", nose_m, "m")
    require_positive("unicycle brake_per_s", brake_per_s, "1/s")
    d = Parameter.of("drag", drag)
    x, u, w = ca.SX.sym("x", 5), ca.SX.sym("u", 2), ca.SX.sym("w", 2)
    place, heading, speeds = x[:2], x[2], x[3:]
    v, turn = x[3], x[4]
    forward = ca.vertcat(ca.cos(heading), ca.sin(heading))
    left = ca.vertcat(-ca.sin(heading), ca.cos(heading))
    nose, nose_rate = place + nose_m * forward, v * forward + nose_m * turn * left
    without_turning = ca.vertcat(nose_m * turn**2, -v * turn / nose_m)
    return Robot(
        system=System(
            x=x,
            u=u,
            f=ca.vertcat(v * forward, turn, u - d.symbol * speeds),
            y=ca.vertcat(v, nose_m**2 * turn),
            parameters=(d,),
        ),
        position=nose,
        velocity=nose_rate,
        points=1,
        fail_safe=without_turning - (brake_per_s - drag) * speeds,
        fail_safe_scope=FailSafeScope(kept_gains=(brake_per_s,)),
        fail_safe_condition=f"{braking_condition(brake_per_s)}; followed at every instant",
        stopping_hull=stopping_segment(nose, nose_rate, brake_per_s),
        feedback=without_turning,
        storage=(v**2 + nose_m**2 * turn**2) / 2,
        task=TaskFrame(command=w, u_h=ca.vertcat(ca.dot(forward, w), ca.dot(left, w) / nose_m), axes=("x", "y")),
        drawing=Drawing(points=place, heading=heading, outline=tuple((nose_m * a, nose_m * b) for a, b in _OUTLINE)),
        input_unit="m/s², rad/s²",
        state_units=("m", "m", "rad", "m/s", "rad/s"),
    )
