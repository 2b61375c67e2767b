"""Schema of ``operator.source`` in scenario files: script, device, simulated person or adversary."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from passafe_services.scenarios.fields import Config, NonNegative, Positive, Vector

Seed = Annotated[int, Field(ge=0, lt=2**63)]


class LagSource(Config):
    """First-order lag from 0 to ``target``: u_h = target·(1 − exp(−t/T)).

    Attributes:
        target: Final value, units of u.
        time_constant_s: T, s.
    """

    kind: Literal["lag"]
    target: Vector
    time_constant_s: Positive


class ConstantSource(Config):
    """The same u_h throughout.

    Attributes:
        value: u_h, units of u.
    """

    kind: Literal["constant"]
    value: Vector


class SineSource(Config):
    """u_h = offset + amplitude·sin(2π f t + phase), each axis with the same frequency.

    Attributes:
        amplitude: Of each axis, units of u.
        frequency_hz: f, Hz.
        offset: Of each axis, units of u; 0 by default.
        phase_rad: Of each axis, rad; 0 by default.
    """

    kind: Literal["sine"]
    amplitude: Vector
    frequency_hz: Positive
    offset: Vector | None = None
    phase_rad: Vector | None = None


class Waypoint(Config):
    """One waypoint; between two of them the command is interpolated.

    Attributes:
        at_s: Plant time, s.
        value: u_h at that time, units of u.
    """

    at_s: NonNegative
    value: Vector


class WaypointSource(Config):
    """u_h interpolated linearly through waypoints, held before the first and after the last.

    Attributes:
        points: Waypoints with increasing times.
    """

    kind: Literal["waypoints"]
    points: Annotated[tuple[Waypoint, ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _times_increase(self) -> Self:
        _require_increasing("points", [point.at_s for point in self.points])
        return self


class RecordedSource(Config):
    """A recorded command series.

    Attributes:
        path: CSV file with a column ``time_s`` and one column ``u_h_<i>`` per axis.
    """

    kind: Literal["recorded"]
    path: str


class KeyboardSource(Config):
    """A person at the keyboard of the terminal.

    Attributes:
        authority: Largest ‖u_h‖, units of u.
    """

    kind: Literal["keyboard"]
    authority: Positive = 15.0


class Target(Config):
    """One target of a simulated person.

    Attributes:
        at_s: Plant time from which it is the target, s.
        position: Where the robot should be, m.
    """

    at_s: NonNegative
    position: Vector


class HumanSource(Config):
    """A simulated person who steers by sight: McRuer's crossover model (``docs/operators.md``).

    Attributes:
        targets: Targets with increasing times.
        crossover_rad_per_s: Gain of person and robot together, rad/s.
        reaction_s: Delay from eye to muscle, s.
        neuromuscular_s: Lag of the arm, s.
        glance_s: Time between two looks at the screen, s.
        remnant: Density of the person's random share, relative to the variance of what is seen, s/rad.
        remnant_bandwidth_rad_per_s: Its bandwidth, rad/s.
        authority: Largest ‖u_h‖, units of u.
        tolerance_m: Distance within which a target counts as reached, m.
        seed: Of the remnant.
    """

    kind: Literal["human"]
    targets: Annotated[tuple[Target, ...], Field(min_length=1)]
    crossover_rad_per_s: Annotated[float, Field(ge=0.1, le=10)] = 2.0
    reaction_s: Annotated[float, Field(ge=0.02, le=2)] = 0.2
    neuromuscular_s: Annotated[float, Field(ge=0.01, le=1)] = 0.1
    glance_s: Annotated[float, Field(ge=0.005, le=0.25)] = 0.02
    remnant: Annotated[float, Field(ge=0, le=0.1)] = 0.01
    remnant_bandwidth_rad_per_s: Annotated[float, Field(ge=1, le=1000)] = 20.0
    authority: Positive = 15.0
    tolerance_m: Positive = 0.1
    seed: Seed = 1

    @model_validator(mode="after")
    def _times_increase(self) -> Self:
        _require_increasing("targets", [target.at_s for target in self.targets])
        return self


class AdversarySource(Config):
    """An operator who wants the robot to fail, as in a campaign.

    Attributes:
        strategy: ``piecewise-constant`` commands another value about once a second; ``chirp`` oscillates from 0.1 to
            50 Hz; ``against-h`` pushes into the tightest barrier; ``bang-bang`` does so with alternating sign;
            ``against-the-tank`` pushes where energy is drawn fastest. The last three go by the newest state that
            reached the operator.
        strength: Largest magnitude of every axis of u_h.
        seed: Of its random choices.
    """

    kind: Literal["adversary"]
    strategy: Literal["piecewise-constant", "chirp", "bang-bang", "against-h", "against-the-tank"]
    strength: Positive = 20.0
    seed: Seed = 1


ScriptSource = LagSource | ConstantSource | SineSource | WaypointSource | RecordedSource | KeyboardSource
"""Sources that depend on the robot only through its number of inputs."""

SourceConfig = Annotated[ScriptSource | HumanSource | AdversarySource, Field(discriminator="kind")]


def _require_increasing(field: str, times_s: Sequence[float]) -> None:
    if any(later <= earlier for earlier, later in pairwise(times_s)):
        raise ValueError(f"{field}: got at_s {list(times_s)}, allowed strictly increasing times")
