"""Sets of states: how the error of a predicted state grows from period to period, and how well a measured one fits."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import inf
from threading import RLock
from typing import Final

import casadi as ca

from passafe.arguments.numbers import described, vectors
from passafe.design import FilterDesign
from passafe.errors import DesignError, ShapeError
from passafe.margins.error_flow import error_flow
from passafe.margins.plant_family import PlantFamily
from passafe.numerics.workspace import BlockLayout, Workspace, dense_function, named_function
from passafe.sampled_plant import held_flow
from passafe.uncertainty import Uncertainty

ROUNDING: Final = 1e-9
"""Distance that never counts as one, relative to 1 + |x|."""

CHUNKS: Final = (8, 1)
"""Periods that one call of a compiled function follows, the most first."""


@dataclass(frozen=True, kw_only=True, slots=True)
class StateSet:
    """A box of states.

    Attributes:
        center: Its middle, n numbers.
        radius: Half its width in every state, n numbers.
    """

    center: tuple[float, ...]
    radius: tuple[float, ...]


class ErrorGrowth:
    """Follows the sets of states that a design's uncertainty allows.

    Attributes:
        design: What it was derived from.
        at_measurement: Error of a state that was just measured, n numbers.
        period: From (x, radius), a column, and u to both one period later; without the substeps of a stiff plant.
    """

    def __init__(self, design: FilterDesign) -> None:
        """Derive and compile the growth over one period, ``dt_s``.

        Raises:
            DesignError: The design has no uncertainty, or the dynamics an operation without an enclosure.
        """
        if not isinstance(design.uncertainty, Uncertainty):
            raise DesignError("uncertainty", described(design.uncertainty), "a design with an Uncertainty")
        system, self.design = design.system, design
        self.at_measurement = tuple(design.uncertainty.state_error) or (0.0,) * system.n
        self._sizes = (system.n, system.m, system.n)
        radius = ca.SX.sym("radius", system.n)
        flow = error_flow(system, PlantFamily.of(design, design.uncertainty), radius, design.dt_s)
        after = ca.if_else(flow.known, flow.radius, inf)
        step = named_function("grow", {"x": system.x, "u": system.u, "radius": radius}, {"radius_next": after})
        sizes = {"x": system.n, "u": system.m, "radius": system.n, "radius_next": system.n}
        self._space = space = Workspace(BlockLayout.of(sizes))
        self._grow, self._one_at_a_time = space.bind(step), RLock()
        self._write = space.span_writer(("x", "u", "radius"))
        self._read = space.reader("radius_next")
        x_next = held_flow(system, design.dt_s)[0]
        pair = dense_function("pair", [ca.vertcat(system.x, radius), system.u], [ca.vertcat(x_next, after)])
        self.period = pair
        self._chunks = {periods: _Chunk(pair, periods) for periods in CHUNKS}

    def advance(self, x: Sequence[float], u: Sequence[float], radius: Sequence[float]) -> tuple[float, ...]:
        """Return the error one period later, n numbers; infinite where no bound of it is known.

        Args:
            x: Predicted state at the beginning, n numbers.
            u: Input sent for this period, m numbers.
            radius: Largest error of the state, n numbers.

        Raises:
            ShapeError: Another number of numbers.
        """
        if (len(x), len(u), len(radius)) != self._sizes:
            got = f"lengths {len(x)}, {len(u)}, {len(radius)}"
            raise ShapeError("x, u, radius", got, "lengths {}, {}, {}".format(*self._sizes))
        with self._one_at_a_time:
            self._write(*x, *u, *radius)
            self._grow()
            return self._read()

    def roll(self, start: StateSet, inputs: Sequence[Sequence[float]]) -> StateSet:
        """Return the set of states after one period under each of the inputs, in a few calls of compiled code.

        A nonlinear plant takes one step a period, of the accuracy that ``SampledPlant`` states.

        Args:
            start: Where it begins.
            inputs: An input of m numbers for each period.

        Raises:
            ShapeError: Another number of numbers.
        """
        n, m = self._sizes[:2]
        center, radius = vectors({"center": start.center, "radius": start.radius}, (n, n))
        if any(len(u) != m for u in inputs):
            raise ShapeError("inputs", f"lengths {sorted({len(u) for u in inputs})}", f"{m} numbers each")
        pair, first = (*center, *radius), 0
        for periods, chunk in self._chunks.items():
            while len(inputs) - first >= periods:
                pair = chunk.follow(pair, inputs[first : first + periods])
                first += periods
        return StateSet(center=pair[:n], radius=pair[n:])

    def residual(self, predicted: StateSet, measured: Sequence[float]) -> tuple[float, ...]:
        """Return how far a measured state lies from the middle of what is allowed, n factors: 1 on the boundary.

        Args:
            predicted: Set of the states that the plant may be in when it is measured.
            measured: What was measured, n numbers, itself off by up to the design's state error.

        Raises:
            ShapeError: Another number of numbers.
        """
        n = self._sizes[0]
        given = {"center": predicted.center, "radius": predicted.radius, "measured": measured}
        center, radius, found = vectors(given, (n, n, n))
        return tuple(
            abs(x - c) / (r + e + ROUNDING * (1 + abs(c)))
            for x, c, r, e in zip(found, center, radius, self.at_measurement, strict=True)
        )


class _Chunk:
    """Several periods in one call."""

    def __init__(self, pair: ca.Function, periods: int) -> None:
        """Unroll a period's function from state and error to state and error."""
        size, m = pair.numel_in(0), pair.numel_in(1)
        before, inputs = ca.SX.sym("before", size), ca.SX.sym("inputs", m, periods)
        after = before
        for k in range(periods):
            after = pair(after, inputs[:, k])
        whole = named_function("roll", {"before": before, "inputs": ca.vec(inputs)}, {"after": after})
        self._space = space = Workspace(BlockLayout.of({"before": size, "inputs": m * periods, "after": size}))
        self._write = space.span_writer(("before", "inputs"))
        self._roll, self._read = space.bind(whole), space.reader("after")
        self._one_at_a_time = RLock()

    def follow(self, before: tuple[float, ...], inputs: Sequence[Sequence[float]]) -> tuple[float, ...]:
        """Return state and error after as many inputs as there are periods."""
        with self._one_at_a_time:
            self._write(*before, *chain.from_iterable(inputs))
            self._roll()
            return self._read()
