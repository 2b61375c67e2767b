"""Limits of the input in scenario files: for each axis and side, norms of parts, half-spaces, rates."""

from typing import Annotated, TypeAlias, TypeVar

from pydantic import Discriminator, Field, Tag

from passafe.admissible_shapes import HalfSpace, NormBound
from passafe.limits import Limits
from passafe_services.scenarios.fields import LISTED, SINGLE, Config, Finite, Positive, single_or_listed

Negative = Annotated[float, Field(ge=-1e6, lt=0)]
Number = TypeVar("Number")
_Axes: TypeAlias = Annotated[tuple[Number, ...], Field(min_length=1, max_length=64), Tag(LISTED)]
_OneOrEach: TypeAlias = Annotated[Annotated[Number, Tag(SINGLE)] | _Axes[Number], Discriminator(single_or_listed)]

PositiveAxes: TypeAlias = _OneOrEach[Positive]
FiniteAxes: TypeAlias = _OneOrEach[Finite]
NegativeAxes: TypeAlias = _OneOrEach[Negative]


class InputNormConfig(Config):
    """A limit of the norm over some axes of the input.

    Attributes:
        axes: Numbers of the axes, from 0.
        bound: Largest norm over them.
    """

    axes: Annotated[tuple[Annotated[int, Field(ge=0, le=63)], ...], Field(min_length=1, max_length=64)]
    bound: Positive


class InputHalfSpaceConfig(Config):
    """A limit of a weighted sum of the input's axes.

    Attributes:
        weights: One for each axis.
        bound: Largest sum of weights times axes.
    """

    weights: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=64)]
    bound: Finite


class InputLimitsConfig(Config):
    """Limits of the input.

    Attributes:
        input_bound: Largest magnitude of u: one number for every axis, or a list with one for each.
        input_norm_bound: Largest ‖u‖₂.
        input_rate_bound_per_s: Largest rate of change of u, units of u per s: one number, or one for each axis.
        input_low: Least u, in the place of −`input_bound`: one number, or one for each axis. Zero need not be allowed.
        input_high: Largest u, in the place of `input_bound`.
        input_norms: Limits of the norm over some axes each.
        input_half_spaces: Limits of weighted sums of the axes; several make a polytope.
        input_rate_low_per_s: Least rate of change, negative, in the place of −`input_rate_bound_per_s`.
        input_rate_high_per_s: Largest rate of change, in the place of `input_rate_bound_per_s`.
    """

    input_bound: PositiveAxes = 100.0
    input_norm_bound: Positive | None = None
    input_rate_bound_per_s: PositiveAxes | None = None
    input_low: FiniteAxes | None = None
    input_high: FiniteAxes | None = None
    input_norms: tuple[InputNormConfig, ...] = ()
    input_half_spaces: tuple[InputHalfSpaceConfig, ...] = ()
    input_rate_low_per_s: NegativeAxes | None = None
    input_rate_high_per_s: PositiveAxes | None = None

    def limits(self, m: int) -> Limits:
        """Return the limits for m axes.

        Raises:
            DesignError: Another number of axes, or limits that leave no input.
        """
        return Limits.of(
            m,
            self.input_bound,
            self.input_norm_bound,
            self.input_rate_bound_per_s,
            low=self.input_low,
            high=self.input_high,
            norms=self.norms(),
            half_spaces=self.half_spaces(),
            rate_low_per_s=self.input_rate_low_per_s,
            rate_high_per_s=self.input_rate_high_per_s,
        )

    def norms(self) -> tuple[NormBound, ...]:
        """Return the limits of norms over some axes."""
        return tuple(NormBound(axes=norm.axes, bound=norm.bound) for norm in self.input_norms)

    def half_spaces(self) -> tuple[HalfSpace, ...]:
        """Return the limits of weighted sums."""
        return tuple(HalfSpace(weights=one.weights, bound=one.bound) for one in self.input_half_spaces)
