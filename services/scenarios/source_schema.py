"""Who or what drives: the ``operator.source`` of a scenario file."""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from services.scenarios.fields import Config, NonNegative, Positive, Vector


class LagSource(Config):
    """First-order lag from 0 to ``target``: u_h = target·(1 − exp(−t/T))."""

    kind: Literal["lag"]
    target: Vector
    time_constant_s: Positive


class ConstantSource(Config):
    """The same u_h throughout."""

    kind: Literal["constant"]
    value: Vector


class SineSource(Config):
    """u_h = offset + amplitude·sin(2π f t + phase), each axis with the same frequency."""

    kind: Literal["sine"]
    amplitude: Vector
    frequency_hz: Positive
    offset: Vector | None = None
    phase_rad: Vector | None = None


class Waypoint(Config):
    """At time ``at_s`` the operator asks for ``value``; between waypoints the command is interpolated."""

    at_s: NonNegative
    value: Vector


class WaypointSource(Config):
    """u_h interpolated linearly through waypoints, held before the first and after the last."""

    kind: Literal["waypoints"]
    points: Annotated[tuple[Waypoint, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _times_increase(self) -> Self:
        times = [point.at_s for point in self.points]
        if any(later <= earlier for earlier, later in pairwise(times)):
            raise ValueError(f"points: got at_s {times}, allowed strictly increasing times")
        return self


class RecordedSource(Config):
    """A recorded command series: CSV with a column ``time_s`` and one column ``u_h_<i>`` an axis."""

    kind: Literal["recorded"]
    path: str


class KeyboardSource(Config):
    """A person at the keyboard of the terminal: arrow keys push, the dead-man releases to zero."""

    kind: Literal["keyboard"]
    authority: Positive = 15.0


Source = Annotated[
    LagSource | ConstantSource | SineSource | WaypointSource | RecordedSource | KeyboardSource,
    Field(discriminator="kind"),
]
