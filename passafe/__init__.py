"""Safety and passivity filters for teleoperated robots: pure mathematics, no clock, no network, no files.

A filter is derived from symbolic expressions and then decides, tick by tick::

    robot = damped_point(sigma=1.0, gamma_1=10.0)
    design = FilterDesign(
        system=robot.system,
        u_fb=robot.proportional_derivative(k_p=10.0, k_d=5.0),
        fail_safe=robot.fail_safe,
        barriers=(Barrier(name="disk", h=disk_keep_out(robot.position, centre=(0, 0), radius=1.0), class_k=gains),),
        passivity=Passivity(V=ca.sumsqr(robot.system.x)),
        k_i=100.0,
        dt_s=1e-3,
        input_bound=100.0,
    )
    decision = SafetyPassivityFilter(design).decide(x, u, u_h, u_h_rate)

A name is imported when it is first used, so that a process which needs ``passafe.errors`` alone stays small.
``docs/theory.md`` states the mathematics, ``docs/guarantees.md`` what holds and when.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from passafe.barrier_chain import Barrier, BarrierChain, derive_chain
    from passafe.barriers import (
        box,
        circular_motion,
        disk_keep_in,
        disk_keep_out,
        ellipse_keep_in,
        ellipse_keep_out,
        half_plane,
        oscillating_motion,
        separation,
        speed_limit,
        uniform_motion,
    )
    from passafe.certificate import Tolerance
    from passafe.class_k import ClassK, Cubic, Linear, Piecewise
    from passafe.decision import Decision, Status
    from passafe.design import FilterDesign, Law, Mode
    from passafe.errors import (
        DesignError,
        IntegrationError,
        NotAllowedError,
        PassafeError,
        RelativeDegreeError,
        ShapeError,
    )
    from passafe.filter import SafetyPassivityFilter
    from passafe.models.damped_point import damped_point
    from passafe.models.drag_point import drag_point
    from passafe.models.joint_chain import joint_chain
    from passafe.models.lagged_point import lagged_point
    from passafe.models.robot import Robot
    from passafe.models.saturating_point import saturating_point
    from passafe.models.two_points import two_points
    from passafe.passivity import Passivity, power_margin
    from passafe.sampled_plant import Sample, SampledPlant
    from passafe.storage import kinetic_energy, spring_energy, squared_norm
    from passafe.system import System
    from passafe.tank import Tank

__all__ = [
    "Barrier",
    "BarrierChain",
    "ClassK",
    "Cubic",
    "Decision",
    "DesignError",
    "FilterDesign",
    "IntegrationError",
    "Law",
    "Linear",
    "Mode",
    "NotAllowedError",
    "PassafeError",
    "Passivity",
    "Piecewise",
    "RelativeDegreeError",
    "Robot",
    "SafetyPassivityFilter",
    "Sample",
    "SampledPlant",
    "ShapeError",
    "Status",
    "System",
    "Tank",
    "Tolerance",
    "box",
    "circular_motion",
    "damped_point",
    "derive_chain",
    "disk_keep_in",
    "disk_keep_out",
    "drag_point",
    "ellipse_keep_in",
    "ellipse_keep_out",
    "half_plane",
    "joint_chain",
    "kinetic_energy",
    "lagged_point",
    "oscillating_motion",
    "power_margin",
    "saturating_point",
    "separation",
    "speed_limit",
    "spring_energy",
    "squared_norm",
    "two_points",
    "uniform_motion",
]

_NAMES_OF: Final = {
    "passafe.barrier_chain": ("Barrier", "BarrierChain", "derive_chain"),
    "passafe.barriers": (
        "box",
        "circular_motion",
        "disk_keep_in",
        "disk_keep_out",
        "ellipse_keep_in",
        "ellipse_keep_out",
        "half_plane",
        "oscillating_motion",
        "separation",
        "speed_limit",
        "uniform_motion",
    ),
    "passafe.class_k": ("ClassK", "Cubic", "Linear", "Piecewise"),
    "passafe.decision": ("Decision", "Status"),
    "passafe.design": ("FilterDesign", "Law", "Mode"),
    "passafe.errors": (
        "DesignError",
        "IntegrationError",
        "NotAllowedError",
        "PassafeError",
        "RelativeDegreeError",
        "ShapeError",
    ),
    "passafe.filter": ("SafetyPassivityFilter",),
    "passafe.models.damped_point": ("damped_point",),
    "passafe.models.drag_point": ("drag_point",),
    "passafe.models.joint_chain": ("joint_chain",),
    "passafe.models.lagged_point": ("lagged_point",),
    "passafe.models.robot": ("Robot",),
    "passafe.models.saturating_point": ("saturating_point",),
    "passafe.models.two_points": ("two_points",),
    "passafe.passivity": ("Passivity", "power_margin"),
    "passafe.certificate": ("Tolerance",),
    "passafe.sampled_plant": ("Sample", "SampledPlant"),
    "passafe.storage": ("kinetic_energy", "spring_energy", "squared_norm"),
    "passafe.system": ("System",),
    "passafe.tank": ("Tank",),
}
_MODULE_OF: Final = {name: module for module, names in _NAMES_OF.items() for name in names}


if not TYPE_CHECKING:  # a checker would take any name for granted

    def __getattr__(name: str) -> object:
        """Import a public name when it is first used (PEP 562)."""
        if name not in _MODULE_OF:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        value = getattr(import_module(_MODULE_OF[name]), name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    """Return the public names."""
    return __all__
