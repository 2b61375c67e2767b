"""Barriers for pictures: only what is drawn matters, the chain does not."""

from collections.abc import Iterator

from passafe_services.scenarios.barrier_kinds.barrier_kind import SingleBarrier
from passafe_services.scenarios.barrier_kinds.coordinate_limits import CoordinateLimit
from passafe_services.scenarios.barrier_kinds.disk import DiskBarrier
from passafe_services.scenarios.barrier_kinds.ellipse import EllipseBarrier
from passafe_services.scenarios.barrier_kinds.half_plane import HalfPlaneBarrier
from passafe_services.scenarios.barrier_kinds.keep_apart import ApartBarrier
from passafe_services.scenarios.barrier_kinds.motion import Motion
from passafe_services.scenarios.barrier_kinds.speed_limit import SpeedBarrier
from passafe_services.scenarios.class_k import ClassKConfig

Place = tuple[float, float]
CHAIN = (ClassKConfig(kind="linear", gain=5.0),) * 3


def disk(
    name: str, centre: Place = (0.0, 0.0), radius: float = 1.0, *, keep_in: bool = False, motion: Motion | None = None
) -> DiskBarrier:
    kind = "disk-keep-in" if keep_in else "disk-keep-out"
    return DiskBarrier(kind=kind, name=name, centre=centre, radius=radius, motion=motion, class_k=CHAIN)


def ellipse(
    name: str,
    centre: Place,
    semi_axes: Place,
    rotation_rad: float = 0.0,
    *,
    keep_in: bool = False,
    motion: Motion | None = None,
) -> EllipseBarrier:
    return EllipseBarrier(
        kind="ellipse-keep-in" if keep_in else "ellipse-keep-out",
        name=name,
        centre=centre,
        semi_axes_m=semi_axes,
        rotation_rad=rotation_rad,
        motion=motion,
        class_k=CHAIN,
    )


def half_plane(name: str, normal: Place, offset: float, *, motion: Motion | None = None) -> HalfPlaneBarrier:
    return HalfPlaneBarrier(kind="half-plane", name=name, normal=normal, offset=offset, motion=motion, class_k=CHAIN)


def speed_limit(name: str, limit: float) -> SpeedBarrier:
    return SpeedBarrier(kind="speed-limit", name=name, limit_m_per_s=limit, class_k=CHAIN[:2])


def not_places() -> Iterator[SingleBarrier]:
    """One barrier of each kind that is no place."""
    yield speed_limit("speed", 1.0)
    yield ApartBarrier(kind="keep-apart", name="apart", distance_m=1.0, class_k=CHAIN)
    yield CoordinateLimit(
        kind="coordinate-limits",
        name="joint",
        of="position",
        index=0,
        bound=1.0,
        upper=True,
        unit="rad",
        class_k=CHAIN,
    )
