"""Write a barrier of your own: the closer the robot is to a person, the slower it must be.

Run it with ``python examples/own_barrier.py``. It needs the base install only.
"""

import casadi as ca

from passafe import Barrier, FilterDesign, Linear, Passivity, SafetyPassivityFilter, damped_point, derive_chain

robot = damped_point(sigma=1.0)  # a point mass in the plane: x = (position, velocity), u = force per kilogram
person = ca.DM([0.0, 0.0])

# A barrier is any expression h(x); the state is safe where h ≥ 0. Here: speed² ≤ 0.3² + (distance / 2)².
distance_squared = ca.sumsqr(robot.position - person)
slow_near_a_person = Barrier(
    name="slow near a person",
    h=0.3**2 + distance_squared / 4 - ca.sumsqr(robot.velocity),
    class_k=(Linear(gain=5.0), Linear(gain=5.0)),
)

# The relative degree, how often h must be differentiated until the input appears, is found, not typed.
chain = derive_chain(robot.system, slow_near_a_person)
print(f"relative degree {chain.relative_degree}, ψ₁ = {chain.psi[1]}")

careful = SafetyPassivityFilter(
    FilterDesign(
        system=robot.system,
        u_fb=-robot.velocity,
        fail_safe=robot.fail_safe,
        barriers=(slow_near_a_person,),
        passivity=Passivity(V=ca.sumsqr(robot.velocity) / 2),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=50.0,
    )
)

# Half a metre from the person, moving towards them at 0.38 m/s, and the operator pushes on.
decision = careful.decide(x=(0.5, 0.0, -0.38, 0.0), u=(0.0, 0.0), u_h=(-20.0, 0.0), u_h_rate=(0.0, 0.0))
print(f"requested {decision.u_nominal}, applied {decision.u}: {decision.status.name}")
for name, dual in zip(careful.row_names, decision.duals, strict=True):
    print(f"row {name!r} pushed with {dual:.3f}")  # the multiplier: which row changed the request, and how much
