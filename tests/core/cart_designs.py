"""A cart before a wall, parts of whose design may be anything."""

import casadi as ca

from passafe.barrier_chain import Barrier
from passafe.design import FilterDesign
from passafe.filter import SafetyPassivityFilter
from passafe.passivity import Passivity
from passafe.system import System

X, U = ca.SX.sym("x", 2), ca.SX.sym("u")
CART = System(x=X, u=U, f=ca.vertcat(X[1], U), y=X[1])


def cart(**changes: object) -> FilterDesign:
    parts: dict[str, object] = {
        "system": CART,
        "barriers": [Barrier(name="wall", h=1 - X[0], class_k=(2.0, 2.0, 2.0))],  # type: ignore[arg-type]  # gains
        "passivity": Passivity(V=X[1] ** 2 / 2),
        "k_i": 50.0,
        "dt_s": 1e-3,
        "input_bound": 20.0,
    }
    return FilterDesign(**(parts | changes))  # type: ignore[arg-type]  # parts of many types


def decided(design: FilterDesign) -> bytes:
    return SafetyPassivityFilter(design).decide((0.7, 0.5), (0.0,), (30.0,), (0.0,), start=True).block.tobytes()
