"""Answers of which all slack is counted: that which the program did not see, too.

What the passivity row may lose between samples, or by a member of a design's sets, grows with the input. A program that
takes it for a constant pays for an input at its limits with slack that it does not see, and the next one leads to the
opposite limits: margins never suit the answer.
"""

from functools import partial
from math import inf
from typing import Final, Protocol

import numpy as np

from passafe.decision import ANSWERS, Attempt
from passafe.design import FilterDesign
from passafe.numerics.fixed_order import length
from passafe.numerics.workspace import Array
from passafe.program.decision_block import DecisionBlock
from passafe.symbolic.trust_region import LEAST_TRUST

DESCENT: Final = 10
"""Trust regions from one input in which a cheaper answer is sought, at most."""

NARROWER: Final = 0.25
"""The next trust radius where none is cheaper, as a share of the radius before; the first one, of the limits' reach."""

INSIDE: Final = 1 - 1e-9
"""Share of a trust region of which rounding leaves nothing outside."""

WORTHWHILE: Final = 1e-6
"""Share by which an answer has to be cheaper to be taken."""


class ConfinedAttempts(Protocol):
    """Attempts at one program within trust regions."""

    def confined(
        self, u_lin: Array, trust: Array, *, with_margins: bool = True, with_sets: bool = True, share: float = 1.0
    ) -> Attempt:
        """Attempt once about an input, with answers from a share of its trust region only."""

    def again(self, attempt: Attempt, before: tuple[Array, Array, Array]) -> Attempt:
        """Make a settled attempt once more."""


class SlackDescent:
    """Descent to answers whose cost is less with all of their slack."""

    def __init__(self, design: FilterDesign, block: DecisionBlock, attempts: ConfinedAttempts) -> None:
        """Hold what they are made with.

        Args:
            design: The filter's.
            block: Holds request, program and answer.
            attempts: Makes attempts at the program of the block.
        """
        self._block, self._attempts, self._weight = block, attempts, design.passivity.slack_weight
        self._least: Array = LEAST_TRUST * np.array(design.limits.magnitude)
        self._widest: Array = np.maximum(self._least, NARROWER * design.limits.reach)

    def cheaper(self, attempt: Attempt) -> Attempt:
        """Look for a cheaper answer from the reference input and from the input before.

        Args:
            attempt: A settled one, whose numbers are in the block.
        """
        block, attempts = self._block, self._attempts
        linearization, u_plus = block.linearization, block.evaluation.u_plus
        before = (linearization.u_lin.copy(), linearization.trust_asked.copy(), linearization.tightening.copy())
        confined = partial(
            attempts.confined,
            with_margins=bool(linearization.with_margins.all()),
            with_sets=bool(linearization.with_sets.all()),  # empty without a family
            share=INSIDE,
        )
        least_cost, best = self._cost(attempt), None
        for start in (block.program.u_ref.copy(), block.request.u.copy()):
            u_lin, trust = start, self._least
            for _ in range(DESCENT):
                again = confined(u_lin, trust)
                cost = self._cost(again) if settled_but_for_slack(again) else inf
                if cost < (1 - WORTHWHILE) * least_cost:
                    least_cost, best, u_lin = cost, (u_lin, trust), u_plus.copy()
                    trust = self._widest if trust is self._least else trust
                elif (trust <= self._least).all():
                    break
                else:
                    trust = np.maximum(NARROWER * trust, self._least)
        if best is None:
            return attempts.again(attempt, before)
        again = confined(*best)
        return Attempt(again.status, again.solver, True, again.assessment)

    def _cost(self, attempt: Attempt) -> float:
        """Return what the program's answer costs, all of its slack included."""
        moved = length(self._block.answer.z[: self._block.evaluation.u_plus.size])
        return float(moved**2 + self._weight * max(attempt.assessment.slack, 0.0) ** 2)


def settled_but_for_slack(attempt: Attempt) -> bool:
    """Return whether hard rows are kept, with margins that are valid for the answer."""
    assessment = attempt.assessment
    worst = max(assessment.shortfall, assessment.outside_trust_region, assessment.unknown_margins)
    return attempt.status in ANSWERS and worst <= 0.0
