"""Filter the input of a plant of your own: a cart on a rail that must not hit the buffers.

Run it with ``python examples/library_filter.py``. It needs the base install only.
"""

import casadi as ca

from passafe import Barrier, FilterDesign, Linear, Passivity, SafetyPassivityFilter, SampledPlant, System

DT_S = 1e-3
MASS_KG, DAMPING_NS_PER_M, RAIL_M = 2.0, 0.5, 1.0

# The plant ẋ = f(x, u), y = g(x): x = (position, velocity), u = the motor's force, y = velocity, so that uy is power.
x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
position, velocity = x[0], x[1]
acceleration = (u - DAMPING_NS_PER_M * velocity) / MASS_KG
cart = System(x=x, u=u, f=ca.vertcat(velocity, acceleration), y=velocity)

# One barrier per buffer. The cart is safe where every h(x) ≥ 0. Force shows in the second derivative of h, so a
# barrier needs two class-K functions, which bound how fast h may shrink, and a third for the continuous law.
gains = (Linear(gain=4.0), Linear(gain=4.0), Linear(gain=4.0))
buffers = (
    Barrier(name="left buffer", h=RAIL_M + position, class_k=gains),
    Barrier(name="right buffer", h=RAIL_M - position, class_k=gains),
)

cart_filter = SafetyPassivityFilter(
    FilterDesign(
        system=cart,
        u_fb=ca.SX(0),  # no feedback of its own: the operator's force is the request
        fail_safe=-8.0 * velocity,  # what the cart does when there is no better answer: brake
        barriers=buffers,
        passivity=Passivity(V=MASS_KG * velocity**2 / 2),  # kinetic energy, J
        k_i=100.0,  # how fast the filter's input follows the request, 1/s
        dt_s=DT_S,
        input_bound=50.0,  # N
    )
)

# Closed loop: a careless operator pushes right with 10 N for three seconds.
plant = SampledPlant(cart, MASS_KG * velocity**2 / 2, DT_S)
state: tuple[float, ...] = (0.0, 0.0)
force: tuple[float, ...] = (0.0,)
largest = 0.0
for tick in range(3000):
    decision = cart_filter.decide(x=state, u=force, u_h=(10.0,), u_h_rate=(0.0,))
    force = decision.u  # certified: within the limits, and the nearest to the request that keeps every row
    state = plant.advance(state, force).x
    largest = max(largest, state[0])
    if tick % 500 == 0:
        print(f"t = {tick * DT_S:.1f} s  x = {state[0]:+.3f} m  u = {force[0]:+6.2f} N  {decision.status.name}")
print(f"furthest right: {largest:.4f} m of {RAIL_M} m")
