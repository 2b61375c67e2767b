"""Kinds of barriers that a scenario file may name: those of this folder, and those of installed distributions.

Another kind takes its own file and one line: here, or in the ``pyproject.toml`` of the distribution that brings it::

    [project.entry-points."passafe.barrier_kinds"]
    rounded-box = "my_barriers.rounded_box:RoundedBox"
"""

from functools import reduce
from importlib.metadata import entry_points
from operator import or_
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias, get_args

from pydantic import Field

from passafe_services.scenarios.barrier_kinds.barrier_kind import BarrierKind
from passafe_services.scenarios.barrier_kinds.body_spheres import BallBarrier, LevelBarrier, SpheresApartBarrier
from passafe_services.scenarios.barrier_kinds.coordinate_limits import CoordinatesBarrier
from passafe_services.scenarios.barrier_kinds.disk import DiskBarrier
from passafe_services.scenarios.barrier_kinds.ellipse import EllipseBarrier
from passafe_services.scenarios.barrier_kinds.half_plane import HalfPlaneBarrier
from passafe_services.scenarios.barrier_kinds.keep_apart import ApartBarrier
from passafe_services.scenarios.barrier_kinds.own_barrier import OwnBarrier
from passafe_services.scenarios.barrier_kinds.room import RoomBarrier
from passafe_services.scenarios.barrier_kinds.speed_limit import SpeedBarrier

SHIPPED: Final[tuple[type[BarrierKind], ...]] = (
    DiskBarrier,
    EllipseBarrier,
    HalfPlaneBarrier,
    RoomBarrier,
    SpeedBarrier,
    CoordinatesBarrier,
    ApartBarrier,
    OwnBarrier,
    BallBarrier,
    LevelBarrier,
    SpheresApartBarrier,
)

ENTRY_POINTS: Final = "passafe.barrier_kinds"
"""Group of entry points by which installed distributions add kinds."""


def _installed() -> tuple[type[BarrierKind], ...]:
    """Return the kinds of installed distributions in the order of their names."""
    entries = sorted(entry_points(group=ENTRY_POINTS), key=lambda entry: entry.name)
    return tuple(entry.load() for entry in entries)


BARRIER_KINDS: Final = (*SHIPPED, *_installed())

if TYPE_CHECKING:
    AnyBarrier: TypeAlias = BarrierKind
else:
    AnyBarrier = Annotated[reduce(or_, BARRIER_KINDS), Field(discriminator="kind")]
    """A barrier of any kind, as a field of a schema."""


def kind_words(kind: type[BarrierKind]) -> tuple[str, ...]:
    """Return the words by which a scenario file names a kind."""
    return get_args(kind.model_fields["kind"].annotation)
