"""Who competes in ``filter_step.py``: each turns a request into the input to hold over the next period.

All keep the sampled law's rows of the reference scenario, ψ₂(x, u⁺) ≥ 0 and h_u(x, u⁺) ≥ 0, and look for the
point nearest to u_ref = u + dt·φ. What each does otherwise is said in its ``differs``.
"""

import os
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from passafe_services.scenarios.barrier_kinds.disk import DiskBarrier
from passafe_services.scenarios.design import design_of, robot_of
from passafe_services.scenarios.schema import Scenario

from passafe.barrier_chain import derive_chain
from passafe.decision import Decision
from passafe.derivation import CUSHION, Derivation
from passafe.filter import SafetyPassivityFilter
from passafe.workspace import Array, BlockLayout, Workspace


class Request(NamedTuple):
    """Arguments of one filter step, as ``SafetyPassivityFilter.decide`` takes them."""

    x: tuple[float, ...]
    u: tuple[float, ...]
    u_h: tuple[float, ...]
    u_h_rate: tuple[float, ...]
    tank_j: float


class Contender(Protocol):
    """One filter step, set up and ready.

    Attributes:
        name: In the table.
        differs: What it does more, less or otherwise than ours.
        tolerance: By how much its u⁺ may differ from ours, relative to 1 + ‖u⁺‖.
    """

    name: str
    differs: str
    tolerance: float

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return the arguments of ``step`` in the types that this contender takes fastest; not timed."""
        ...

    def step(self, *arguments: Any) -> Any:  # noqa: ANN401 - every library has its own types
        """Return whatever holds the answer, computed to the end; this is what is timed."""
        ...

    def answer(self, result: Any) -> Sequence[float]:  # noqa: ANN401 - what ``step`` returned
        """Return u⁺ from a result, m numbers; not timed."""
        ...


class Ours:
    """``SafetyPassivityFilter.decide``."""

    name = "passafe"
    differs = "certified; u⁺ bounded; returns ψ, h_u, margins, duals, slack and residuals with it"
    tolerance = 0.0

    def __init__(self, scenario: Scenario) -> None:
        self.step = SafetyPassivityFilter(design_of(scenario, robot_of(scenario))).decide

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return the request as it is."""
        return tuple(request)

    def answer(self, result: Decision) -> Sequence[float]:
        """Return the decision's u."""
        return result.u


class CbfpyWithElastiqp:
    """cbfpy's ``CBF.safety_filter`` with elastiqp as its backend, and u_ref, in one compiled call.

    The disk is a relative-degree-2 barrier with ``alpha_2`` and ``alpha`` of the scenario's first two gains:
    the same ψ₂. Passivity is no function of the state; it becomes one when the tank level E with
    Ė = h_u(x, u) joins the state: the barrier h = E of relative degree 1, at E = 0, gives the row h_u ≥ 0.
    """

    name = "cbfpy + elastiqp"
    differs = "ℓ₁ slack on both rows, ours is quadratic and on passivity only; no certificate, no bound, u⁺ only"
    tolerance = 1e-4

    def __init__(self, scenario: Scenario) -> None:
        # What the README of cbfpy asks for; JAX reads it when it is imported.
        settings = {"JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "1", "OPENBLAS_NUM_THREADS": "1"}
        os.environ |= settings | {"XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
        jax: Any = import_module("jax")
        jax.config.update("jax_enable_x64", True)  # for a JAX that was imported before
        self._step = jax.jit(_cbfpy_step(scenario))

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return NumPy arrays, which JAX takes faster than tuples."""
        return tuple(np.array(part) for part in request[:4])

    def step(self, *arguments: Array) -> Array:
        """Return u⁺ on the host: the conversion waits for the end of the computation."""
        return np.asarray(self._step(*arguments))

    def answer(self, result: Array) -> Sequence[float]:
        """Return the numbers."""
        return tuple(result.tolist())


def _cbfpy_step(scenario: Scenario) -> Callable[..., Any]:
    """Return (x, u, u_h, u̇_h) → u⁺ of cbfpy, not compiled yet.

    The scenario's robot is typed anew here, in JAX; the comparison of answers would tell a mistake.
    """
    cbfpy: Any = import_module("cbfpy")
    jnp: Any = import_module("jax.numpy")
    config, disk = scenario.filter, scenario.filter.barriers[0]
    if not isinstance(disk, DiskBarrier):
        raise TypeError(f"first barrier: got {type(disk).__name__}, allowed DiskBarrier")
    sigma = scenario.plant.parameters["sigma"]
    k_p, k_d, bound, dt_s = config.feedback.k_p, config.feedback.k_d, config.input_bound, scenario.dt_s
    gain_1, gain_2 = disk.class_k[0].gain, disk.class_k[1].gain

    centre, radius = jnp.array(disk.centre), disk.radius

    class Config(cbfpy.CBFConfig):  # type: ignore[misc]  # loaded at run time, no types
        """The damped point with its tank: z = (x₁, x₂, E)."""

        def f(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            drift = 2 * sigma * z[2:4] @ z[2:4] - 2 * z[:2] @ z[2:4]
            return jnp.concatenate([z[2:4], -sigma * z[2:4], drift[None]])

        def g(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return jnp.concatenate([jnp.zeros((2, 2)), jnp.eye(2), -z[None, 2:4]])

        def h_1(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return z[4:]

        def h_2(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            offset = z[:2] - centre
            return jnp.array([offset @ offset - radius**2])

        def alpha(self, h: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return gain_2 * h

        def alpha_2(self, h: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return gain_1 * h

    options = {"backend": "elastiqp", "solver_tol": 1e-6, "cbf_relaxation_penalty": 1e4}
    cbf = cbfpy.CBF.from_config(Config(n=5, m=2, **options))

    def step(x: Any, u: Any, u_h: Any, u_h_rate: Any) -> Any:  # noqa: ANN401 - JAX arrays
        u_nominal = -k_p * x[:2] - k_d * x[2:] + u_h
        u_fb_rate = -k_p * x[2:] - k_d * (u - sigma * x[2:])
        phi = u_fb_rate + u_h_rate + config.k_i * (u_nominal - u)
        u_ref = jnp.clip(u + dt_s * phi, -bound, bound)
        return cbf.safety_filter(jnp.concatenate([x, jnp.zeros(1)]), u_ref)

    return step


class _OnOurRows:
    """A solver behind the same evaluation of rows as ours; nothing certifies or bounds its answer."""

    tolerance = 1e-5

    def __init__(self, scenario: Scenario) -> None:
        design = design_of(scenario, robot_of(scenario))
        derivation = Derivation(design, [derive_chain(design.system, barrier) for barrier in design.barriers])
        given, derived = derivation.sizes_given, derivation.sizes_derived
        self._space = space = Workspace(BlockLayout.of(given | derived))
        self._evaluate = space.bind(derivation.prepare, list(given), list(derived))
        space.part("cushion")[:] = CUSHION * design.tolerance.residual
        asked = sum(given[name] for name in ("x", "u", "u_h", "u_h_rate", "tank"))
        self._given, self._m = space.block[:asked], design.system.m
        self._G = space.matrix("G", (derivation.duties, derivation.k))
        self._u_ref, self._d = space.part("u_ref"), space.part("d")

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return one array of all numbers."""
        return (np.hstack(request),)

    def answer(self, result: Array) -> Sequence[float]:
        """Return the numbers."""
        return tuple(result.tolist())


CVXPY_SOLVERS: Final[dict[str, dict[str, Any]]] = {
    "PIQP": {"eps_abs": 1e-8, "eps_rel": 1e-9},
    "DAQP": {"primal_tol": 1e-8},
    "CLARABEL": {},
    "OSQP": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 100_000, "polishing": False},
}
"""Solvers tried behind cvxpy, with options for an accuracy like ours; the fastest one competes."""


class ParametrisedCvxpy(_OnOurRows):
    """cvxpy with G and d as parameters (DPP): canonicalised once, then only numbers change."""

    differs = "same G and d; no certificate, no bound, u⁺ only"

    def __init__(self, scenario: Scenario, solver: str) -> None:
        super().__init__(scenario)
        cvxpy = import_module("cvxpy")
        rows, size = self._G.shape
        self.name = f"cvxpy, {solver}"
        self._solver, self._options = solver, CVXPY_SOLVERS[solver]
        self._z = cvxpy.Variable(size)
        self._G_now, self._d_now = cvxpy.Parameter((rows, size)), cvxpy.Parameter(rows)
        constraints = [self._G_now @ self._z >= self._d_now]
        self._problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.sum_squares(self._z) / 2), constraints)

    def step(self, *arguments: Array) -> Array:
        """Return u⁺."""
        self._given[:] = arguments[0]
        self._evaluate()
        self._G_now.value, self._d_now.value = self._G, self._d
        self._problem.solve(solver=self._solver, enforce_dpp=True, **self._options)
        plus: Array = self._u_ref + self._z.value[: self._m]
        return plus


class DaqpOnOurRows(_OnOurRows):
    """DAQP, set up once and updated in place."""

    name = "DAQP alone"
    differs = "same G and d; no certificate, no bound, u⁺ only; for information"

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        rows, size = self._G.shape
        self._rows, self._above = np.ones((rows, size)), np.full(rows, 1e30)
        self._model = import_module("daqp").Model()
        senses = np.zeros(rows, dtype=np.intc)
        self._model.setup(np.eye(size), np.zeros(size), self._rows, self._above, np.full(rows, -1.0), senses)

    def step(self, *arguments: Array) -> Array:
        """Return u⁺."""
        self._given[:] = arguments[0]
        self._evaluate()
        self._rows[:] = self._G
        self._model.update(A=self._rows, bupper=self._above, blower=self._d)
        z = self._model.solve()[0]
        plus: Array = self._u_ref + z[: self._m]
        return plus
