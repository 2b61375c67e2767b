"""Puts the program of ``filter_contenders.py`` to cbfpy, with elastiqp as its backend."""

import os
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, cast

import numpy as np
from filter_contenders import Request
from passafe_services.scenarios.barrier_kinds.disk import DiskBarrier
from passafe_services.scenarios.schema import Scenario
from timing import Times


class CbfpyWithElastiqp:
    """cbfpy's ``CBF.safety_filter`` and u_ref in one compiled call.

    The disk is a relative-degree-2 barrier with ``alpha_2`` and ``alpha`` of the scenario's first two gains:
    the same ψ₂. Passivity is no function of the state; it becomes one when the tank level E with
    Ė = h_u(x, u) joins the state: the barrier h = E of relative degree 1, at E = 0, gives the row h_u ≥ 0.
    """

    name = "cbfpy + elastiqp"
    differs = "ℓ₁ slack on all rows, passafe's is quadratic and on passivity only; no certificate; u⁺ only"
    tolerance: float | None = 1e-4

    def __init__(self, scenario: Scenario) -> None:
        """Compile the filter of a scenario."""
        # As the README of cbfpy recommends; JAX reads the environment when it is imported.
        settings = {"JAX_PLATFORMS": "cpu", "JAX_ENABLE_X64": "1", "OPENBLAS_NUM_THREADS": "1"}
        os.environ |= settings | {"XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false"}
        jax: Any = import_module("jax")
        jax.config.update("jax_enable_x64", True)  # for a JAX that cvxpy has imported before
        self._step = jax.jit(_step(scenario))

    def prepare(self, request: Request) -> tuple[Any, ...]:
        """Return NumPy arrays, which JAX reads faster than tuples."""
        return tuple(np.array(part) for part in request)

    def step(self, *arguments: Times) -> Times:
        """Return u⁺ on the host: the conversion waits for the end of the computation."""
        return np.asarray(self._step(*arguments))

    def answer(self, result: Times) -> Sequence[float]:
        """Return the numbers."""
        return tuple(result.tolist())


def _step(scenario: Scenario) -> Callable[..., Any]:
    """Return (x, u, u_h, u̇_h) → u⁺, not compiled yet."""
    jnp: Any = import_module("jax.numpy")
    config, sigma = scenario.filter, scenario.plant.parameters["sigma"]
    k_p, k_d, bound, dt_s = config.feedback.k_p, config.feedback.k_d, cast("float", config.input_bound), scenario.dt_s
    cbf = _cbf(scenario)

    def step(x: Any, u: Any, u_h: Any, u_h_rate: Any) -> Any:  # noqa: ANN401 - JAX arrays
        u_nominal = -k_p * x[:2] - k_d * x[2:] + u_h
        u_fb_rate = -k_p * x[2:] - k_d * (u - sigma * x[2:])
        phi = u_fb_rate + u_h_rate + config.k_i * (u_nominal - u)
        u_ref = jnp.clip(u + dt_s * phi, -bound, bound)
        return cbf.safety_filter(jnp.concatenate([x, jnp.zeros(1)]), u_ref)

    return step


def _cbf(scenario: Scenario) -> Any:  # noqa: ANN401 - loaded at run time, no types
    """Return cbfpy's filter.

    The scenario's robot is written anew here, in JAX; the comparison of answers would reveal a mistake.
    """
    cbfpy: Any = import_module("cbfpy")
    jnp: Any = import_module("jax.numpy")
    bound, disk = cast("float", scenario.filter.input_bound), cast("DiskBarrier", scenario.filter.barriers[0])
    sigma = scenario.plant.parameters["sigma"]
    gain_1, gain_2 = disk.class_k[0].gain, disk.class_k[1].gain
    centre = jnp.array(disk.centre)

    class Config(cbfpy.CBFConfig):  # type: ignore[misc]  # loaded at run time, no types
        """Model of the damped point with its tank: z = (x₁, x₂, E)."""

        def f(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            drift = 2 * sigma * z[2:4] @ z[2:4] - 2 * z[:2] @ z[2:4]
            return jnp.concatenate([z[2:4], -sigma * z[2:4], drift[None]])

        def g(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return jnp.concatenate([jnp.zeros((2, 2)), jnp.eye(2), -z[None, 2:4]])

        def h_1(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return z[4:]

        def h_2(self, z: Any) -> Any:  # noqa: ANN401 - JAX arrays
            offset = z[:2] - centre
            return jnp.array([offset @ offset - disk.radius**2])

        def alpha(self, h: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return gain_2 * h

        def alpha_2(self, h: Any) -> Any:  # noqa: ANN401 - JAX arrays
            return gain_1 * h

    options = {"backend": "elastiqp", "solver_tol": 1e-6, "cbf_relaxation_penalty": 1e4}
    return cbfpy.CBF.from_config(Config(n=5, m=2, u_min=[-bound] * 2, u_max=[bound] * 2, **options))
