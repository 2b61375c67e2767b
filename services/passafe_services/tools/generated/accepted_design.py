"""The check of a generated design: what ``passafe check`` would say of it before anything moves."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from passafe.checks.backup_start import backup_findings, is_kept_from
from passafe.checks.design_check import check_design
from passafe.checks.driven_states import driven_findings
from passafe.checks.row_share import StateBox
from passafe.errors import IntegrationError
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Finding, Severity
from passafe_services.loop.machine_code import machine_code
from passafe_services.tools.generated.generated_design import GeneratedDesign
from passafe_services.tools.generated.protected_set import ProtectedSet

SAMPLES: Final = 32
"""Random states of a check: a decision in a fallback is a slow one."""

LOOP_OPERATORS: Final = 2
"""Operators that drive from the start of every single loop."""

STREAM: Final = 0xC4EC
"""First part of the seed of the start that a check is given."""


def start_of_check(design: GeneratedDesign, protected: ProtectedSet) -> tuple[float, ...] | None:
    """Return a random start in the protected set; ``None`` if no random state of the box is in it.

    Args:
        design: The design.
        protected: Its protected set.
    """
    inside, _ = protected.draw(np.random.default_rng([STREAM, design.seed]))
    return tuple(inside[:, 0].tolist()) if inside.size else None


def built(design: GeneratedDesign, x0: Sequence[float] | None) -> SafetyPassivityFilter:
    """Return the filter of a design, with a gatekeeper if it is to have one and that has something to hold on to.

    Args:
        design: The design.
        x0: Start of its check.

    Raises:
        DesignError: The core refuses a part of it.
    """
    core = SafetyPassivityFilter(design.filter_design(), compiler=machine_code)
    return (guarded(design, core, x0) or core) if design.gatekeeper else core


def guarded(
    design: GeneratedDesign, core: SafetyPassivityFilter, x0: Sequence[float] | None
) -> SafetyPassivityFilter | None:
    """Return a design's filter with a gatekeeper, as the check advises where operators get into a fallback.

    Args:
        design: The design.
        core: Its filter without one.
        x0: Start of its check.

    Returns:
        The filter; ``None`` if the fail-safe law is not proven to keep every barrier from the start.
    """
    if x0 is None or not is_kept_from(core, x0):
        return None
    return SafetyPassivityFilter(design.filter_design(gatekeeper=True), compiler=machine_code)


def check_warnings(
    design: GeneratedDesign, core: SafetyPassivityFilter, x0: tuple[float, ...] | None
) -> tuple[tuple[Severity, str], ...]:
    """Return the findings of a design that are more than notes.

    Args:
        design: The design.
        core: Its filter.
        x0: Start of its check.
    """
    if x0 is None:
        return ((Severity.WARNING, "no random state of the box is in the protected set"),)
    box = StateBox(x0=x0, low=design.plant.low, high=design.plant.high)
    try:
        findings = check_design(core, box, samples=SAMPLES, seed=design.seed)
    except IntegrationError as error:
        return ((Severity.WARNING, str(error)),)
    return tuple((each.severity, str(each)) for each in findings if each.severity is not Severity.NOTE)


def start_warning(core: SafetyPassivityFilter, x0: Sequence[float], seed: int) -> str:
    """Return what a check of one loop's own start finds; empty if it is clean.

    Args:
        core: The filter.
        x0: The start, n numbers.
        seed: Seed of the loop.
    """
    try:
        findings: tuple[Finding, ...] = (
            *driven_findings(core, x0, SAMPLES, seed, LOOP_OPERATORS),
            *backup_findings(core, x0),
        )
    except IntegrationError as error:
        return str(error)
    return "; ".join(str(found) for found in findings if found.severity is not Severity.NOTE)
