"""Random states that a scenario's rows protect: the starts of rollouts."""

from typing import Final

import casadi as ca
import numpy as np

from passafe.filter import SafetyPassivityFilter
from passafe.numerics.workspace import Array
from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.campaign.errors import NoSafeStartError

MOST_DRAWS: Final = 20_000
START_MARGIN: Final = 1e-6
WIDTH: Final = 3.0
"""Half width of the box where the scenario gives none, in each state's own units."""


class SafeStarts:
    """Draws states in which every ψ but the last is positive and the filter has a certified first input."""

    def __init__(self, scenario: Scenario, core: SafetyPassivityFilter) -> None:
        """Compile what makes a state safe.

        Args:
            scenario: Gives the box that states are drawn from.
            core: Its filter.
        """
        system = core.design.system
        self._core, self._name = core, scenario.name
        self._low = scenario.plant.start_low or (-WIDTH,) * system.n
        self._high = scenario.plant.start_high or (WIDTH,) * system.n
        self._zero = (0.0,) * system.m
        self._tank_j = scenario.filter.passivity.tank_initial_j
        protected = [psi for chain in core.chains for psi in chain.psi[:-1]]
        at_start = ca.substitute(ca.vertcat(ca.SX(0, 1), *protected), system.t, 0.0)
        self._inside = ca.Function("inside", [system.x], [at_start])

    def draw(self, rng: np.random.Generator) -> Array:
        """Return a random safe state, uniform over those of the box, shape (n,).

        Raises:
            NoSafeStartError: There is none among ``MOST_DRAWS`` states of the box.
        """
        zero = self._zero
        for _ in range(MOST_DRAWS):
            x = rng.uniform(self._low, self._high)
            if float(np.min(self._inside(x).full(), initial=np.inf)) < START_MARGIN:
                continue
            first = self._core.decide(x.tolist(), zero, zero, zero, self._tank_j, 0.0, start=True)
            if not first.status.is_fallback:
                return np.asarray(x)
        raise NoSafeStartError(self._name, self._low, self._high, MOST_DRAWS)
