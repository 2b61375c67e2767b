"""The family of plants that a design's sets allow: ẋ = f(x, u + du, c) + w, in the form in which rows and tubes use it.

Where f is affine in the reciprocal of a parameter, as in that of a mass, the reciprocal takes the parameter's place: a
function that is affine in a coordinate c is least at an end of its interval, whatever it is multiplied with.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import casadi as ca
import numpy as np

from passafe.design import FilterDesign
from passafe.enclosures.reachable_tube import HeldMotion
from passafe.errors import DesignError
from passafe.parameter import Parameter
from passafe.system import System
from passafe.uncertainty import Uncertainty

ROUNDED: Final = 0.03
"""|a| is bounded by √(a² + ROUNDED²) where it must have a slope, in the units of a."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Coordinate:
    """A parameter with an interval, or its reciprocal.

    Attributes:
        name: The parameter's.
        symbol: What stands for it in ``PlantFamily.system``.
        low: Its least value.
        high: Its largest one.
        is_affine: Whether f is affine in it.
        is_reciprocal: Whether it is one over the parameter.
    """

    name: str
    symbol: ca.SX
    low: float
    high: float
    is_affine: bool
    is_reciprocal: bool

    @property
    def centre(self) -> float:
        """Middle of its interval."""
        return (self.low + self.high) / 2

    @property
    def radius(self) -> float:
        """Half the width of its interval."""
        return (self.high - self.low) / 2

    def distance(self, parameter: float) -> float:
        """Return how far it may be from where the parameter has a value."""
        value = 1 / parameter if self.is_reciprocal else parameter
        return max(self.high - value, value - self.low)

    def parameter_at(self, value: float) -> float:
        """Return the parameter where the coordinate has a value."""
        return 1 / value if self.is_reciprocal else value


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class PlantFamily:
    """Plants that are all allowed, and the one in their middle.

    Attributes:
        system: The plant with all coordinates in the middle of their intervals, which are its parameters.
        coordinates: Of the parameters that are not known exactly.
        disturbance: Largest |wᵢ|, shape (n, 1), state units per second.
        input_error: Largest |duᵢ|, shape (m, 1), units of u.
    """

    system: System
    coordinates: tuple[Coordinate, ...]
    disturbance: ca.DM
    input_error: ca.DM

    @classmethod
    def of(cls, design: FilterDesign, uncertainty: Uncertainty) -> "PlantFamily":
        """Return the family of a design and its sets."""
        nominal = design.system
        known = {each.name: each.value for each in nominal.parameters if each.name not in uncertainty.parameters}
        f = ca.substitute([nominal.general_f], *_values(nominal, known))[0]
        coordinates = []
        for parameter in nominal.parameters:
            low, high = uncertainty.parameters.get(parameter.name, (parameter.value,) * 2)
            if parameter.name in uncertainty.parameters:
                f, coordinate = _with_coordinate(f, parameter, low, high)
                coordinates.append(coordinate)
        system = System(
            x=nominal.x,
            u=nominal.u,
            f=f,
            y=nominal.y,
            t=nominal.t,
            port_y=nominal.port_y,
            port_u=nominal.port_u,
            parameters=tuple(Parameter(name=c.name, symbol=c.symbol, value=c.centre) for c in coordinates),
        )
        return cls(
            system=system,
            coordinates=tuple(coordinates),
            disturbance=ca.DM(list(uncertainty.disturbance or (0.0,) * nominal.n)),
            input_error=ca.DM(_input_error(design, uncertainty)),
        )

    @property
    def symbols(self) -> ca.SX:
        """Symbols of all coordinates, a column."""
        return ca.vertcat(ca.SX(0, 1), *(each.symbol for each in self.coordinates))

    @property
    def centres(self) -> ca.SX:
        """Middles of their intervals, a column."""
        return ca.SX(ca.DM([each.centre for each in self.coordinates]))

    @property
    def radii(self) -> ca.SX:
        """Half their widths, a column."""
        return ca.SX(ca.DM([each.radius for each in self.coordinates]))

    def motion(self, x_radius: ca.SX, input_radius: ca.SX) -> HeldMotion:
        """Return how all members move from near x under inputs near u.

        Args:
            x_radius: Error of x, expression, shape (n, 1).
            input_radius: By how much the input may differ from u, its error left aside, expression, shape (m, 1).
        """
        return HeldMotion(
            f=self.system.general_f,
            x=self.system.x,
            x_radius=x_radius,
            held=ca.vertcat(self.system.u, self.symbols),
            held_radius=ca.vertcat(input_radius + self.input_error, self.radii),
            constants=self.symbols,
            values=tuple(each.centre for each in self.coordinates),
            push=self.disturbance,
        )

    def ends(self, rate: ca.SX) -> tuple[Coordinate, ...]:
        """Return the coordinates at whose ends a row is asked for: in which it is affine and by which u is multiplied.

        Args:
            rate: q, expression of x, u, t and the coordinates.
        """
        effect = ca.gradient(rate, self.system.u)
        return tuple(each for each in self.coordinates if each.is_affine and ca.depends_on(effect, each.symbol))

    def members(self, ends: Sequence[Coordinate]) -> dict[str, System]:
        """Return the members at all combinations of some coordinates' ends, by what they differ in.

        Args:
            ends: The coordinates; all others are in the middle.
        """
        found = {}
        for corner in product(*((each.low, each.high) if each.radius else (each.low,) for each in ends)):
            values = {each.name: value for each, value in zip(ends, corner, strict=True)}
            text = ", ".join(f"{c.name}={c.parameter_at(value):g}" for c, value in zip(ends, corner, strict=True))
            found[text] = self.system.with_parameters(values)
        return found

    def reserve(self, psi: ca.SX) -> ca.SX:
        """Return a smooth bound of how much less the rate of ψ may be than the middle member's, where u has no effect.

        Args:
            psi: Expression of x and t.

        Raises:
            DesignError: A parameter that it depends on in no affine way.
        """
        slope = ca.gradient(psi, self.system.x)
        least = sum((self.disturbance[i] * _rounded(slope[i]) for i in range(self.system.n)), ca.SX(0))
        general = ca.jtimes(psi, self.system.x, self.system.general_f)
        for each in self.coordinates:
            effect = self.system.at_nominal(ca.gradient(general, each.symbol))
            if not each.is_affine and not ca.simplify(effect).is_zero():
                raise DesignError(
                    f"uncertainty parameters {each.name!r}",
                    "a parameter by which a barrier's rate is neither multiplied nor divided before the input acts",
                    "dynamics that are affine in it or in its reciprocal; or bound what it does as a disturbance",
                )
            least += each.radius * _rounded(effect)
        return least


def _rounded(value: ca.SX) -> ca.SX:
    """Return a bound of |value| that has a slope everywhere."""
    value = ca.simplify(value)
    return ca.fabs(value) if value.is_constant() else ca.sqrt(value**2 + ROUNDED**2)


def _with_coordinate(f: ca.SX, parameter: Parameter, low: float, high: float) -> tuple[ca.SX, Coordinate]:
    """Return the dynamics with a coordinate in the place of a parameter, and the coordinate."""
    symbol = ca.SX.sym(parameter.name)
    for is_reciprocal in (False, True) if low * high > 0 else (False,):
        inside = 1 / symbol if is_reciprocal else symbol
        with_it = ca.substitute(f, parameter.symbol, inside)
        if not ca.depends_on(ca.simplify(ca.jacobian(with_it, symbol)), symbol):
            ends = sorted((1 / low, 1 / high)) if is_reciprocal else (low, high)
            coordinate = Coordinate(
                name=parameter.name,
                symbol=symbol,
                low=ends[0],
                high=ends[1],
                is_affine=True,
                is_reciprocal=is_reciprocal,
            )
            return with_it, coordinate
    coordinate = Coordinate(
        name=parameter.name, symbol=symbol, low=low, high=high, is_affine=False, is_reciprocal=False
    )
    return ca.substitute(f, parameter.symbol, symbol), coordinate


def _values(system: System, known: dict[str, float]) -> tuple[list[ca.SX], list[ca.SX]]:
    """Return symbols and values of the parameters that are known."""
    chosen = [each for each in system.parameters if each.name in known]
    return [each.symbol for each in chosen], [ca.SX(each.value) for each in chosen]


def _input_error(design: FilterDesign, uncertainty: Uncertainty) -> list[float]:
    """Return the largest error of each input: the one that is given, and what a lag makes of a rate limit."""
    given = np.array(uncertainty.input_error or (0.0,) * design.system.m)
    if uncertainty.actuator_lag_s and design.limits.fall_per_s and design.limits.rise_per_s:
        given = given + uncertainty.actuator_lag_s * np.maximum(design.limits.fall_per_s, design.limits.rise_per_s)
    found: list[float] = given.tolist()
    return found
