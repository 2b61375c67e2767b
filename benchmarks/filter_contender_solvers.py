"""Puts the program of ``filter_contenders.py`` to cvxpy and to a solver alone, its rows evaluated by CasADi."""

from collections.abc import Sequence
from importlib import import_module
from typing import Any, Final

import casadi as ca
import numpy as np
from filter_contenders import Request
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario
from timing import Times

from passafe import derive_chain, power_margin

CVXPY_SOLVERS: Final[dict[str, dict[str, Any]]] = {
    "PIQP": {"eps_abs": 1e-8, "eps_rel": 1e-9},
    "DAQP": {"primal_tol": 1e-8},
    "CLARABEL": {},
    "OSQP": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 100_000, "polishing": False},
}
"""Solvers tried behind cvxpy, with options for an accuracy like that of passafe; the fastest one competes."""


class _OnCasadiRows:
    """Rows A u⁺ ≥ b, (ψ₂, h_u) in this order, and u_ref, evaluated into arrays that stay in place."""

    tolerance: float | None = 1e-5

    def __init__(self, scenario: Scenario) -> None:
        """Derive the rows of a scenario."""
        design = design_of(scenario, robot_of(scenario))
        system, bound = design.system, design.limits.high[0]
        u_h, u_h_rate = ca.SX.sym("u_h", system.m), ca.SX.sym("u_h_rate", system.m)
        u_fb_rate = ca.jtimes(design.u_fb, system.x, system.f)
        phi = u_fb_rate + u_h_rate + design.k_i * (design.u_fb + u_h - system.u)
        kept = [derive_chain(system, barrier).psi[-1] for barrier in design.barriers]
        values = ca.vertcat(*kept, power_margin(system, design.passivity.V))
        A = ca.jacobian(values, system.u)
        b = -ca.substitute(values, system.u, ca.SX.zeros(system.m))
        u_ref = ca.fmax(ca.fmin(system.u + design.dt_s * phi, bound), -bound)
        arguments = [system.x, system.u, u_h, u_h_rate]
        function = ca.Function("rows", [ca.vertcat(*arguments)], [ca.densify(part) for part in (A, b, u_ref)])
        self._m, self._rows, self._bound = system.m, A.shape[0], float(bound)
        self._given = np.zeros(function.numel_in())
        self._A = np.zeros((self._rows, self._m), order="F")
        self._b, self._u_ref = np.zeros(self._rows), np.zeros(self._m)
        buffer: Any
        buffer, self._evaluate = function.buffer()
        self._buffer = buffer  # the function writes to its memory for as long as it lives
        buffer.set_arg(0, self._given.data)
        for i, array in enumerate((self._A.T.reshape(-1), self._b, self._u_ref)):
            buffer.set_res(i, array.data)
        self._root = float(np.sqrt(design.passivity.slack_weight))

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return one array of all numbers."""
        return (np.hstack(request),)

    def answer(self, result: Times) -> Sequence[float]:
        """Return the numbers."""
        return tuple(result.tolist())


class ParametrisedCvxpy(_OnCasadiRows):
    """cvxpy with A, b and u_ref as parameters (DPP): canonicalised once, then only numbers change."""

    differs = "no certificate; u⁺ only"

    def __init__(self, scenario: Scenario, solver: str) -> None:
        """State the problem to cvxpy."""
        super().__init__(scenario)
        cvxpy = import_module("cvxpy")
        self.name = f"cvxpy, {solver}"
        self._solver, self._options = solver, CVXPY_SOLVERS[solver]
        self._parameters = [cvxpy.Parameter(array.shape) for array in (self._A, self._b, self._u_ref)]
        A, b, u_ref = self._parameters
        self._plus, slack = cvxpy.Variable(self._m), cvxpy.Variable()  # the slack in units of δ·√ρ
        hard = self._rows - 1
        constraints = [A[:hard] @ self._plus >= b[:hard], A[hard] @ self._plus + slack / self._root >= b[hard]]
        constraints += [self._plus >= -self._bound, self._plus <= self._bound]
        distance = cvxpy.sum_squares(self._plus - u_ref) + cvxpy.square(slack)
        self._problem = cvxpy.Problem(cvxpy.Minimize(distance / 2), constraints)

    def step(self, *arguments: Times) -> Times:
        """Return u⁺."""
        self._given[:] = arguments[0]
        self._evaluate()
        for parameter, array in zip(self._parameters, (self._A, self._b, self._u_ref), strict=True):
            parameter.value = array
        self._problem.solve(solver=self._solver, enforce_dpp=True, **self._options)
        plus: Times = self._plus.value
        return plus


class DaqpAlone(_OnCasadiRows):
    """DAQP, set up once and updated in place; the limits are its simple bounds."""

    name = "DAQP alone"
    differs = "no certificate; u⁺ only; a solver, not a filter"

    def __init__(self, scenario: Scenario) -> None:
        """Set the solver up; its variables are u⁺ and δ·√ρ."""
        super().__init__(scenario)
        m, rows = self._m, self._rows
        self._full = np.zeros((rows, m + 1))
        self._full[-1, m] = 1 / self._root
        self._low = np.full(m + 1 + rows, -self._bound)
        self._high = np.full(m + 1 + rows, self._bound)
        self._low[m], self._high[m] = -1e30, 1e30
        self._high[m + 1 :] = 1e30
        self._linear = np.zeros(m + 1)
        self._model = import_module("daqp").Model()
        senses = np.zeros(m + 1 + rows, dtype=np.intc)
        self._model.setup(np.eye(m + 1), self._linear, self._full, self._high, self._low, senses)

    def step(self, *arguments: Times) -> Times:
        """Return u⁺."""
        m = self._m
        self._given[:] = arguments[0]
        self._evaluate()
        self._full[:, :m] = self._A
        self._low[m + 1 :] = self._b
        self._linear[:m] = -self._u_ref
        self._model.update(f=self._linear, A=self._full, bupper=self._high, blower=self._low)
        plus: Times = self._model.solve()[0][:m]
        return plus
