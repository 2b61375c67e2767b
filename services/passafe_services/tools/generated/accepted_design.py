"""The check of a generated design: what ``passafe check`` would say of it before anything moves."""

from typing import Final

import numpy as np

from passafe.design_check import check_design
from passafe.errors import IntegrationError
from passafe.filter import SafetyPassivityFilter
from passafe.finding import Severity
from passafe.row_share import StateBox
from passafe_services.tools.generated.generated_design import GeneratedDesign
from passafe_services.tools.generated.protected_set import ProtectedSet

SAMPLES: Final = 32
"""Random states of a check, and as many that operators reach: a decision in a fallback is a slow one."""

STREAM: Final = 0xC4EC
"""First part of the seed of the start that a check is given."""


def check_warnings(
    design: GeneratedDesign, core: SafetyPassivityFilter, protected: ProtectedSet
) -> tuple[tuple[Severity, str], ...]:
    """Return the findings of a design that are more than notes, from a random start in its protected set.

    Args:
        design: The design.
        core: Its filter.
        protected: Its protected set.
    """
    inside, _ = protected.draw(np.random.default_rng([STREAM, design.seed]))
    if not inside.size:
        return ((Severity.WARNING, "no random state of the box is in the protected set"),)
    x0 = tuple(inside[:, 0].tolist())
    box = StateBox(x0=x0, low=design.plant.low, high=design.plant.high)
    try:
        findings = check_design(core, box, samples=SAMPLES, seed=design.seed)
    except IntegrationError as error:
        return ((Severity.WARNING, str(error)),)
    return tuple((each.severity, str(each)) for each in findings if each.severity is not Severity.NOTE)
