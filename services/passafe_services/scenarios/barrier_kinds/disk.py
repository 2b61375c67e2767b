"""Disks: ``disk-keep-out`` and ``disk-keep-in``."""

from typing import ClassVar, Literal

import casadi as ca

from passafe.barriers.disk import disk_keep_in, disk_keep_out
from passafe_services.scenarios.barrier_kinds.outline import Outline, ellipse_border
from passafe_services.scenarios.barrier_kinds.point_barrier import PlaceBarrier
from passafe_services.scenarios.fields import Place, Positive


class DiskBarrier(PlaceBarrier):
    """A disk to keep out of, h = ‖p − centre‖² − radius², m², or to stay in, −h.

    Attributes:
        centre: Centre before it has moved, m.
        radius: Radius, m.
    """

    h_unit: ClassVar[str] = "m²"

    kind: Literal["disk-keep-out", "disk-keep-in"]
    centre: Place
    radius: Positive

    def h_at(self, position: ca.SX) -> ca.SX:
        """Return h of a position."""
        disk = disk_keep_out if self.kind == "disk-keep-out" else disk_keep_in
        return disk(position, centre=self.centre, radius=self.radius)

    def still_outline(self) -> Outline:
        """Return the circle."""
        c1, c2 = self.centre
        outline = Outline.keep_out if self.kind == "disk-keep-out" else Outline.keep_in
        return outline(ellipse_border(self.centre, (self.radius, self.radius)), (c1, c2))
