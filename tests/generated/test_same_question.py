"""The same question with another input before has the same status, where the limits do not depend on that input."""

from typing import Final

import numpy as np
import pytest
from passafe_services.tools.generated.generated_design import GeneratedDesign

from passafe.decision import ANSWERS, Status
from passafe.filter import SafetyPassivityFilter

STATES: Final = 12
INPUTS: Final = 5


@pytest.mark.parametrize("number", [14, 46])
def test_the_input_before_does_not_decide_the_status(number: int) -> None:
    """Of a stable plant at 110 Hz and a cart-pole at 35 Hz many states allow inputs at samples, but no margins."""
    design = GeneratedDesign.of(number)
    core = SafetyPassivityFilter(design.filter_design())
    rng, limits = np.random.default_rng([7, number]), core.design.limits
    rest, tank_j = [0.0] * len(limits.low), core.design.passivity.initial_j
    unsettled = 0
    for x in rng.uniform(design.plant.low, design.plant.high, (STATES, core.design.system.n)).tolist():
        asked = rng.uniform(limits.low, limits.high, (INPUTS, 2, len(limits.low))).tolist()
        found = {core.decide(x, u, u_h, rest, tank_j).status for u, u_h in asked}
        assert found <= set(ANSWERS) or len(found) == 1, x
        unsettled += bool(found & {Status.AT_SAMPLES, Status.BACKUP})
    assert core.design.input_rate_bound_per_s is None
    assert unsettled > STATES / 4
