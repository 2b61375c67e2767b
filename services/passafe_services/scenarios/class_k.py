"""Class-K functions as a scenario file states them."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from passafe.class_k import ClassK, Cubic, Linear, Piecewise
from passafe_services.scenarios.fields import Config, Positive


class ClassKConfig(Config):
    """One extended class-K function γ: ``linear`` is gain·s, ``cubic`` gain·s³.

    ``piecewise`` is gain·s for s > 0 and gain_below·s otherwise.

    Attributes:
        kind: Kind of function.
        gain: Gain, 1/s; per squared unit of s and second for ``cubic``.
        gain_below: Gain of ``piecewise`` for s ≤ 0, 1/s.
    """

    kind: Literal["linear", "cubic", "piecewise"]
    gain: Positive
    gain_below: Positive | None = None

    @model_validator(mode="after")
    def _gain_below_where_it_belongs(self) -> Self:
        if (self.gain_below is not None) != (self.kind == "piecewise"):
            raise ValueError(f"gain_below: got {self.gain_below}, allowed with kind 'piecewise' and only there")
        return self

    def function(self) -> ClassK:
        """Return γ as the core's object."""
        if self.kind == "linear":
            return Linear(gain=self.gain)
        if self.kind == "cubic":
            return Cubic(gain=self.gain)
        return Piecewise(gain=self.gain, gain_below=self.gain_below or self.gain)


Chain = Annotated[tuple[ClassKConfig, ...], Field(min_length=1, max_length=6)]
"""γ₁ … γ_{r+1} of a barrier with relative degree r."""
