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

if TYPE_CHECKING:  # imported under their own names: exported, for type checkers
    from passafe.admissible_shapes import HalfSpace as HalfSpace
    from passafe.admissible_shapes import NormBound as NormBound
    from passafe.barrier_chain import Barrier as Barrier
    from passafe.barrier_chain import BarrierChain as BarrierChain
    from passafe.barrier_chain import derive_chain as derive_chain
    from passafe.barrier_chain import derive_chains as derive_chains
    from passafe.barriers import box as box
    from passafe.barriers import circular_motion as circular_motion
    from passafe.barriers import disk_keep_in as disk_keep_in
    from passafe.barriers import disk_keep_out as disk_keep_out
    from passafe.barriers import ellipse_keep_in as ellipse_keep_in
    from passafe.barriers import ellipse_keep_out as ellipse_keep_out
    from passafe.barriers import half_plane as half_plane
    from passafe.barriers import oscillating_motion as oscillating_motion
    from passafe.barriers import separation as separation
    from passafe.barriers import speed_limit as speed_limit
    from passafe.barriers import uniform_motion as uniform_motion
    from passafe.certificate import Tolerance as Tolerance
    from passafe.checks.design_check import check_design as check_design
    from passafe.checks.row_share import StateBox as StateBox
    from passafe.class_k import ClassK as ClassK
    from passafe.class_k import Cubic as Cubic
    from passafe.class_k import Linear as Linear
    from passafe.class_k import Piecewise as Piecewise
    from passafe.decision import Decision as Decision
    from passafe.decision import Status as Status
    from passafe.design import FilterDesign as FilterDesign
    from passafe.design import Law as Law
    from passafe.design import Mode as Mode
    from passafe.errors import DesignError as DesignError
    from passafe.errors import IntegrationError as IntegrationError
    from passafe.errors import NotAllowedError as NotAllowedError
    from passafe.errors import PassafeError as PassafeError
    from passafe.errors import RelativeDegreeError as RelativeDegreeError
    from passafe.errors import ShapeError as ShapeError
    from passafe.filter import SafetyPassivityFilter as SafetyPassivityFilter
    from passafe.finding import Finding as Finding
    from passafe.finding import Severity as Severity
    from passafe.models.damped_point import damped_point as damped_point
    from passafe.models.drag_point import drag_point as drag_point
    from passafe.models.drawing import Drawing as Drawing
    from passafe.models.fail_safe_scope import FailSafeScope as FailSafeScope
    from passafe.models.joint_chain import joint_chain as joint_chain
    from passafe.models.lagged_point import lagged_point as lagged_point
    from passafe.models.robot import Robot as Robot
    from passafe.models.saturating_point import saturating_point as saturating_point
    from passafe.models.task_frame import TaskFrame as TaskFrame
    from passafe.models.two_points import two_points as two_points
    from passafe.models.unicycle import unicycle as unicycle
    from passafe.parameter import Parameter as Parameter
    from passafe.passivity import Passivity as Passivity
    from passafe.passivity import power_margin as power_margin
    from passafe.sampled_plant import Sample as Sample
    from passafe.sampled_plant import SampledPlant as SampledPlant
    from passafe.state_set import ErrorGrowth as ErrorGrowth
    from passafe.state_set import StateSet as StateSet
    from passafe.storage import kinetic_energy as kinetic_energy
    from passafe.storage import spring_energy as spring_energy
    from passafe.storage import squared_norm as squared_norm
    from passafe.system import System as System
    from passafe.tank import Tank as Tank
    from passafe.uncertainty import Uncertainty as Uncertainty

_NAMES_OF: Final = {
    "passafe.admissible_shapes": ("HalfSpace", "NormBound"),
    "passafe.barrier_chain": ("Barrier", "BarrierChain", "derive_chain", "derive_chains"),
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
    "passafe.checks.design_check": ("check_design",),
    "passafe.finding": ("Finding", "Severity"),
    "passafe.checks.row_share": ("StateBox",),
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
    "passafe.models.drawing": ("Drawing",),
    "passafe.models.fail_safe_scope": ("FailSafeScope",),
    "passafe.models.joint_chain": ("joint_chain",),
    "passafe.models.lagged_point": ("lagged_point",),
    "passafe.models.robot": ("Robot",),
    "passafe.models.saturating_point": ("saturating_point",),
    "passafe.models.task_frame": ("TaskFrame",),
    "passafe.models.two_points": ("two_points",),
    "passafe.models.unicycle": ("unicycle",),
    "passafe.parameter": ("Parameter",),
    "passafe.passivity": ("Passivity", "power_margin"),
    "passafe.certificate": ("Tolerance",),
    "passafe.sampled_plant": ("Sample", "SampledPlant"),
    "passafe.state_set": ("ErrorGrowth", "StateSet"),
    "passafe.storage": ("kinetic_energy", "spring_energy", "squared_norm"),
    "passafe.system": ("System",),
    "passafe.tank": ("Tank",),
    "passafe.uncertainty": ("Uncertainty",),
}
_MODULE_OF: Final = {name: module for module, names in _NAMES_OF.items() for name in names}

__all__ = sorted(_MODULE_OF)  # noqa: PLE0605 - names, sorted


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
