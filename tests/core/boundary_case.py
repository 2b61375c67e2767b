"""States on and near the boundaries of one shape on one robot."""

from functools import cached_property
from typing import ClassVar, NamedTuple, Protocol

import casadi as ca
import numpy as np
from finite_differences import Array
from shipped_robots import ROBOTS, Shipped, columns

from passafe.barrier_chain import Barrier, derive_chain
from passafe.class_k import ClassK
from passafe.models.robot import Robot

NEAR = np.concatenate([[0.0], *([10.0**-k, -(10.0**-k)] for k in range(1, 10))])
"""Distances from a boundary: none, and 1e-9 to 1e-1 to both sides."""


class OnBoundary(NamedTuple):
    """A place on a boundary.

    Attributes:
        place: Coordinates that the shape is about.
        inward: Unit vector into the safe set.
    """

    place: Array
    inward: Array


class Suite(Protocol):
    """Answers of a suite about its shape; see ``BarrierSuite``."""

    of: ClassVar[str]

    def h(self, robot: Robot) -> ca.SX:
        """Return the shape on a robot."""

    def on_boundary(self, rng: np.random.Generator, t: float) -> OnBoundary:
        """Return a random place on the boundary."""


class Case:
    """One shape on one robot.

    Attributes:
        robot: The robot.
        shipped: What is known of it otherwise.
        barrier: The shape as a barrier.
        psi: ψ₀ … ψ_r as functions of columns of x, u and t.
    """

    def __init__(self, suite: Suite, name: str, class_k: tuple[ClassK, ...]) -> None:
        self.suite = suite
        self.shipped: Shipped = ROBOTS[name]
        self.robot: Robot = self.shipped.build(class_k[0].gain, class_k[1].gain)
        self.degree = self.shipped.degree - (suite.of == "velocity")
        self.barrier = Barrier(name="shape", h=suite.h(self.robot), class_k=class_k[: self.degree + 1])
        self.chain = derive_chain(self.robot.system, self.barrier)
        system = self.robot.system
        self.symbols = [system.x, system.u, system.t]
        self.psi = [columns(self.symbols, psi) for psi in self.chain.psi]
        self.slope = [
            columns(self.symbols, ca.jacobian(psi, ca.vertcat(system.x, system.t)).T) for psi in self.chain.psi
        ]

    @cached_property
    def rows(self) -> slice:
        """Return the indices of the shape's coordinates in x."""
        k = self.shipped.coordinates
        return slice(0, k) if self.suite.of == "position" else slice(k, 2 * k)

    def samples(self, seed: int, each: int = 3) -> tuple[Array, Array, Array]:
        """Return columns of x, u and t: at every distance of ``NEAR`` from h = 0, everything else at random."""
        rng = np.random.default_rng(seed)
        system = self.robot.system
        states, times = [], []
        for distance in np.repeat(NEAR, each):
            t = rng.uniform(0, 5)
            x = rng.uniform(-2, 2, system.n)
            place, inward = self.suite.on_boundary(rng, t)
            x[self.rows] = place + distance * inward
            states.append(x)
            times.append([t])
        return np.array(states).T, rng.uniform(-3, 3, (system.m, len(states))), np.array(times).T

    def near(self, level: int, seed: int, distances: Array = NEAR) -> tuple[Array, Array, Array]:
        """Return columns of x, u and t with ψ_level at every one of the distances from zero, found by Newton's method.

        The level's ψ must not contain u.
        """
        x, u, t = self.samples(seed)
        wanted = np.resize(distances, x.shape[1])
        for _ in range(100):
            miss = self.psi[level](x, u, t)[0] - wanted
            slope = self.slope[level](x, u, t)[:-1]
            x = x - slope * miss / np.maximum((slope**2).sum(axis=0), 1e-12)
        found = np.abs(self.psi[level](x, u, t)[0] - wanted) <= 1e-11
        assert found.mean() > 0.9
        return x[:, found], u[:, found], t[:, found]

    def everywhere(self, seed: int) -> list[tuple[Array, Array, Array]]:
        """Return columns of x, u and t on and near every boundary h = 0, ψ₁ = 0, …, ψ_{r−1} = 0."""
        return [self.samples(seed), *(self.near(level, seed) for level in range(1, self.degree))]

    def protected(self, seed: int) -> tuple[Array, Array]:
        """Return columns of x and t with ψ₀ … ψ_{r−1} ≥ 0, many of them with some ψ at zero."""
        parts = [self.near(level, seed, np.maximum(NEAR, 0)) for level in range(self.degree)]
        x, u, t = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
        kept = np.all([psi(x, u, t)[0] >= 0 for psi in self.psi[:-1]], axis=0)
        assert kept.sum() > 10
        return x[:, kept], t[:, kept]
