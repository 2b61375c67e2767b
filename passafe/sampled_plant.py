"""The plant under an input that is held: exact for linear dynamics, of stated accuracy otherwise."""

import struct
from collections.abc import Sequence
from threading import RLock
from typing import Final

import casadi as ca
import numpy as np
from msgspec import Struct

from passafe.arguments.expressions import as_column
from passafe.arguments.numbers import described, one_number, vectors
from passafe.arguments.ranges import require_positive
from passafe.errors import DesignError, IntegrationError
from passafe.numerics.fixed_order import exponential
from passafe.numerics.stage import Stage, T
from passafe.numerics.workspace import BlockLayout, Workspace, dense_function, expressions_by_name, named_function
from passafe.system import System

LOCAL_TOLERANCE: Final = 1e-10
"""Largest estimated local error of one period of a nonlinear plant, in each state's own units and in J.

An energy beyond 1 J counts by its share.
"""

MAX_SUBSTEPS: Final = 256
"""Substeps of a period beyond which a nonlinear plant counts as not integrable."""


class Sample(Struct, frozen=True, gc=False):
    """The plant at the end of a period.

    Attributes:
        x: State, n numbers.
        y: Output g(x), as many numbers as the system has outputs.
        stored_j: V(x), J.
        energy_in_j: ∫yᵀu dt of the port over the period, J.
        integration_error: Estimated local error of x; 0 where the step is exact.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]
    stored_j: float
    energy_in_j: float
    integration_error: float


class HeldStep(Stage[T], frozen=True, eq=False, gc=False):
    """Arguments of a step under an input that is held.

    Attributes:
        x: State at its beginning, n.
        u: Input, m.
        h: Its length, s, 1.
    """

    x: T
    u: T
    h: T


class AfterStep(Stage[T], frozen=True, eq=False, gc=False):
    """The plant after a step.

    Attributes:
        x_next: State at its end, n.
        y: Output there.
    """

    x_next: T
    y: T


class StepEnergy(Stage[T], frozen=True, eq=False, gc=False):
    """Scalars of a step.

    Attributes:
        stored: V at its end, J.
        energy: ∫yᵀu over it, J.
        error: Estimated local error of x.
    """

    stored: T
    energy: T
    error: T


class SampledPlant:
    """Steps ẋ = f(x, u) over periods in which u is constant.

    Attributes:
        system: The plant.
        V: Storage function, scalar expression of x, J.
        dt_s: Period, s.
        exact: Whether the steps are exact: f linear in (x, u), g and the port's output linear in x,
            up to constants.
        layout: Places of a step's arguments and results.
        step: ``HeldStep`` → ``AfterStep`` and ``StepEnergy``; a step takes ``dt_s`` where it is exact, else h seconds.
    """

    def __init__(self, system: System, V: ca.SX, dt_s: float) -> None:
        """Derive the step.

        Args:
            system: The plant.
            V: Storage function, scalar expression of x, J.
            dt_s: Period, s.

        Raises:
            DesignError: No system, a V that is no function of its state, or a period that is not positive and finite.
        """
        if not isinstance(system, System):
            raise DesignError("system", described(system), "a System")
        V = as_column("storage V", V)
        system.require_state_function("storage V", V, 1)
        self.system, self.V = system, V
        require_positive("dt_s", dt_s, "s")
        self.dt_s = dt_s = one_number("dt_s", dt_s)
        self.exact = is_linear(system)
        held = HeldStep(x=system.x, u=system.u, h=ca.SX.sym("h"))
        x_next, energy, error = held_flow(system, dt_s if self.exact else held.h)
        y, stored = ca.substitute([system.y, V], [system.x], [x_next])
        after, scalars = AfterStep(x_next=x_next, y=y), StepEnergy(stored=stored, energy=energy, error=error)
        self.layout = BlockLayout.of_stages(held, after, scalars)
        self.step = named_function("advance", expressions_by_name(held), expressions_by_name(after, scalars))
        self._space = space = Workspace(self.layout)
        self._advance = space.bind(self.step)
        self._observe = dense_function("observe", [system.x], [system.y, V])
        self._write = HeldStep.of(space.writer)
        self._read = AfterStep.of(space.reader)
        self._read_energy = space.scalar_reader(StepEnergy[float])
        self._one_at_a_time = RLock()

    def at(self, x: Sequence[float]) -> Sample:
        """Return the sample of a state at the start.

        Args:
            x: State, n numbers.

        Raises:
            ShapeError: Another number of numbers, or something that is no real number.
        """
        (state,) = vectors({"x": x}, (self.system.n,))
        y, stored = self._observe(ca.DM(state))
        return Sample(state, tuple(y.full().ravel().tolist()), float(stored), 0.0, 0.0)

    def advance(self, x: Sequence[float], u: Sequence[float]) -> Sample:
        """Return the plant one period later.

        Args:
            x: State at the beginning, n numbers: any sequence, as for ``SafetyPassivityFilter.decide``.
            u: Input held over the period, m numbers.

        Raises:
            ShapeError: An argument of the wrong length, or that holds something that is no real number.
            IntegrationError: A nonlinear plant's step missed its accuracy even with ``MAX_SUBSTEPS``.
        """
        if not type(x) is type(u) is tuple:
            x, u = self._converted(x, u)
        sample = self._step(x, u, self.dt_s)
        if not sample.integration_error <= LOCAL_TOLERANCE:
            return self._in_substeps(x, u)
        return sample

    def _step(self, x: Sequence[float], u: Sequence[float], h: float) -> Sample:
        write, read = self._write, self._read
        with self._one_at_a_time:
            try:
                write.x(*x)
                write.u(*u)
            except struct.error:  # of the wrong length, or not all of them are plain numbers
                x, u = self._converted(x, u)
                write.x(*x)
                write.u(*u)
            write.h(h)
            self._advance()
            energy = self._read_energy()
            return Sample(read.x_next(), read.y(), energy.stored, energy.energy, energy.error)

    def _converted(self, x: object, u: object) -> list[tuple[float, ...]]:
        return vectors({"x": x, "u": u}, (self.system.n, self.system.m))

    def _in_substeps(self, x: Sequence[float], u: Sequence[float]) -> Sample:
        substeps, error = 2, float("inf")
        while substeps <= MAX_SUBSTEPS:
            sample = Sample(tuple(x), (), 0.0, 0.0, 0.0)
            energy = error = 0.0
            for _ in range(substeps):
                sample = self._step(sample.x, u, self.dt_s / substeps)
                energy += sample.energy_in_j
                error += sample.integration_error
            if error <= LOCAL_TOLERANCE:
                return Sample(sample.x, sample.y, sample.stored_j, energy, error)
            substeps *= 2
        raise IntegrationError(error, LOCAL_TOLERANCE, substeps // 2)


def is_linear(system: System) -> bool:
    """Return whether f is linear in (x, u), and g and the port's output linear in x, all up to constants."""
    z = ca.vertcat(system.x, system.u)
    outputs = (system.y, system.port_y)
    slopes = [ca.jacobian(system.f, z), *(ca.jacobian(output, system.x) for output in outputs)]
    return not any(ca.symvar(ca.simplify(slope)) for slope in slopes)


def held_flow(system: System, h: float | ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return (x after h seconds, ∫yᵀu dt, estimated local error of x) as expressions of the system's x and u.

    y and u are the port's here. Linear systems: the matrix exponential of [x, ∫y, u, 1], exact up to rounding (Van Loan
    1978). Others: two half steps of the classical fourth-order Runge–Kutta method, improved by Richardson extrapolation
    against one whole step, whose difference is the error estimate (Hairer, Nørsett & Wanner, II.4).

    Args:
        system: The plant.
        h: Seconds; a number for linear systems, a number or a symbol for others.
    """
    if is_linear(system):
        x_next, q = _linear_flow(system, float(h))
        return x_next, ca.dot(q, system.port_u), ca.SX(0)
    x_next, q, error = _runge_kutta_flow(system, ca.SX(h))
    return x_next, ca.dot(q, system.port_u), error


def _linear_flow(system: System, h: float) -> tuple[ca.SX, ca.SX]:
    """Return x and q = ∫y after h seconds: the flow of [ẋ; q̇; u̇; 1̇] = M [x; q; u; 1]."""
    x, u, n, m, k = system.x, system.u, system.n, system.m, system.port_y.numel()
    parts = [ca.jacobian(system.f, x), ca.jacobian(system.f, u), ca.jacobian(system.port_y, x)]
    A, B, C = (ca.DM(ca.simplify(part)).full() for part in parts)
    rest = ca.Function("rest", [x, u], [system.f, system.port_y])
    f0, y0 = (value.full().ravel() for value in rest(ca.DM.zeros(n), ca.DM.zeros(m)))
    M = np.zeros((n + k + m + 1,) * 2)
    M[:n, :n], M[:n, n + k : n + k + m], M[:n, -1] = A, B, f0
    M[n : n + k, :n], M[n : n + k, -1] = C, y0
    after = ca.DM(exponential(M * h)) @ ca.vertcat(x, ca.DM.zeros(k), u, 1)
    return after[:n], after[n : n + k]


def _runge_kutta_flow(system: System, h: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return x, q = ∫y and the error estimate of x after h seconds."""
    n = system.n
    rate = ca.Function("rate", [system.x, system.u], [ca.vertcat(system.f, system.port_y)])

    def step(s: ca.SX, h: ca.SX) -> ca.SX:
        k1 = rate(s[:n], system.u)
        k2 = rate((s + h / 2 * k1)[:n], system.u)
        k3 = rate((s + h / 2 * k2)[:n], system.u)
        k4 = rate((s + h * k3)[:n], system.u)
        return s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    start = ca.vertcat(system.x, ca.SX.zeros(system.port_y.numel()))
    whole = step(start, h)
    halves = step(step(start, h / 2), h / 2)
    correction = (halves - whole) / 15
    energy = (halves + correction)[n:] * system.port_u
    # Of megajoules in a period, as a truck takes, rounding alone is more than the tolerance.
    relative = correction[n:] * system.port_u / ca.fmax(1, ca.fabs(energy))
    # A norm that a NaN spoils, and ∫y belongs to it: the energy ledger lives on it.
    return ((halves + correction)[:n], (halves + correction)[n:], ca.norm_2(ca.vertcat(correction[:n], relative)))
