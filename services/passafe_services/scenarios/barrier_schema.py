"""What a scenario file may say of barriers: where they are, how they move, their class-K functions.

Places are in the plane. A barrier of a model with several points holds for each of them, or for the one that it names.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from passafe_services.scenarios.fields import Config, Finite, Positive, Vector

Name = Annotated[str, Field(min_length=1, max_length=40)]
Place = Annotated[tuple[Finite, ...], Field(min_length=2, max_length=2)]
Point = Annotated[int, Field(ge=1, le=2)]


class ClassKConfig(Config):
    """One extended class-K function γ: ``linear`` is gain·s, ``cubic`` gain·s³.

    ``piecewise`` is gain·s for s > 0 and gain_below·s otherwise.
    """

    kind: Literal["linear", "cubic", "piecewise"]
    gain: Positive
    gain_below: Positive | None = None

    @model_validator(mode="after")
    def _gain_below_where_it_belongs(self) -> Self:
        if (self.gain_below is not None) != (self.kind == "piecewise"):
            raise ValueError(f"gain_below: got {self.gain_below}, allowed with kind 'piecewise' and only there")
        return self


Chain = Annotated[tuple[ClassKConfig, ...], Field(min_length=1, max_length=6)]


class Travel(Config):
    """Steady motion: velocity·t away from where it is at plant time 0."""

    kind: Literal["travel"]
    velocity_m_per_s: Place


class Swing(Config):
    """To and fro on a line: amplitude·sin(2π f t + phase) away from its middle."""

    kind: Literal["swing"]
    amplitude_m: Place
    frequency_hz: Annotated[float, Field(gt=0, le=10)]
    phase_rad: Finite = 0.0


class Circle(Config):
    """Counter-clockwise on a circle: radius·(cos, sin)(2π f t + phase) away from its middle."""

    kind: Literal["circle"]
    radius_m: Positive
    frequency_hz: Annotated[float, Field(gt=0, le=10)]
    phase_rad: Finite = 0.0


Motion = Annotated[Travel | Swing | Circle, Field(discriminator="kind")]


class DiskBarrier(Config):
    """Keep out of a disk: h = ‖p − centre‖² − radius², m²; ``disk-keep-in``: −h."""

    kind: Literal["disk-keep-out", "disk-keep-in"]
    name: Name
    centre: Place
    radius: Positive
    motion: Motion | None = None
    point: Point | None = None
    class_k: Chain


class EllipseBarrier(Config):
    """Keep out of an ellipse: h = a²(‖D⁻¹Rᵀ(p − centre)‖² − 1), m², D the semi-axes, a the shorter one.

    R turns by ``rotation_rad``, counter-clockwise. ``ellipse-keep-in``: −h.
    """

    kind: Literal["ellipse-keep-out", "ellipse-keep-in"]
    name: Name
    centre: Place
    semi_axes_m: Annotated[tuple[Positive, ...], Field(min_length=2, max_length=2)]
    rotation_rad: Finite = 0.0
    motion: Motion | None = None
    point: Point | None = None
    class_k: Chain


class HalfPlaneBarrier(Config):
    """Stay on one side of a line: h = normalᵀp − offset; m where the normal has unit length."""

    kind: Literal["half-plane"]
    name: Name
    normal: Place
    offset: Finite
    motion: Motion | None = None
    point: Point | None = None
    class_k: Chain

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if not any(self.normal):
            raise ValueError(f"normal: got {self.normal}, allowed a vector that is not zero")
        return self


class RoomBarrier(Config):
    """Stay in a room: four half-planes, ``<name> left``, ``right``, ``bottom`` and ``top``; h in m."""

    kind: Literal["room"]
    name: Name
    low_m: Place
    high_m: Place
    point: Point | None = None
    class_k: Chain

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        _require_above("low_m, high_m", self.low_m, self.high_m)
        return self


class SpeedBarrier(Config):
    """Stay below a speed: h = limit² − ‖v‖², (m/s)²."""

    kind: Literal["speed-limit"]
    name: Name
    limit_m_per_s: Positive
    point: Point | None = None
    class_k: Chain


class CoordinatesBarrier(Config):
    """Keep every coordinate of position or velocity between limits, as joints have.

    Two barriers for coordinate i, counted from 1: ``<name> <i> low`` with h = qᵢ − low, ``<name> <i> high`` with
    h = high − qᵢ, in the coordinate's unit. ``low`` and ``high`` have one number for each.
    """

    kind: Literal["coordinate-limits"]
    name: Name
    of: Literal["position", "velocity"] = "position"
    low: Vector
    high: Vector
    class_k: Chain

    @model_validator(mode="after")
    def _has_an_inside(self) -> Self:
        _require_above("low, high", self.low, self.high)
        return self


class ApartBarrier(Config):
    """Keep the two robots of model ``two-points`` apart: h = ‖p₁ − p₂‖² − distance², m²."""

    kind: Literal["keep-apart"]
    name: Name
    distance_m: Positive
    class_k: Chain


BarrierConfig = Annotated[
    DiskBarrier | EllipseBarrier | HalfPlaneBarrier | RoomBarrier | SpeedBarrier | CoordinatesBarrier | ApartBarrier,
    Field(discriminator="kind"),
]


def _require_above(field: str, low: tuple[float, ...], high: tuple[float, ...]) -> None:
    if len(low) != len(high) or any(top <= bottom for bottom, top in zip(low, high, strict=True)):
        raise ValueError(f"{field}: got {low}, {high}, allowed as many numbers in both, every high above its low")
