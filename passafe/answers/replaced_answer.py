"""Another input in the place of the program's answer: above all the backup law's."""

from collections.abc import Callable
from typing import Final

from passafe.decision import Attempt
from passafe.limits import Limits
from passafe.numerics.workspace import Array
from passafe.program.decision_block import DecisionBlock
from passafe.symbolic.decision_functions import DecisionFunctions

BACKUP: Final = "backup"
"""Name of the solver where the input is the backup law's."""

DEEPEST: Final = "deepest"
"""Name of the solver where the input is the one that keeps the hard rows best."""

BETWEEN: Final = "between"
"""Name of the solver where the input lies between the backup law's and another one, and keeps the barriers longest."""


class ReplacedAnswer:
    """Puts inputs into a ``DecisionBlock`` that no program has found."""

    def __init__(self, limits: Limits, block: DecisionBlock, functions: DecisionFunctions[Callable[[], None]]) -> None:
        """Hold what the input is evaluated with.

        Args:
            limits: The filter's.
            block: Holds request, program and answer.
            functions: Bound to the block.
        """
        self._limits, self._block, self._functions = limits, block, functions

    def input_before(self) -> Array:
        """Return the input from which the rate is limited; at the start, when none is, that is the backup law's own."""
        request = self._block.request
        return self.backup_input() if request.start[0] else request.u

    def backup_input(self) -> Array:
        """Return the backup law's input, within the limits, shape (m,)."""
        block, limits = self._block, self._limits
        kept = block.evaluation.u_plus.copy()
        self._functions.fail_safe()
        law, program = block.evaluation.u_plus.copy(), block.program
        block.evaluation.u_plus[:] = kept
        return limits.nearest(law, block.request.u, program.low, program.high)

    def send_backup(self, attempt: Attempt) -> Attempt:
        """Send the backup law's input.

        Args:
            attempt: The attempt in whose place it is sent.
        """
        self._functions.prepare()  # an answer may have been confined to less than the limits
        return self.send(self.backup_input(), BACKUP, attempt)

    def send(self, u_plus: Array, solver: str, attempt: Attempt) -> Attempt:
        """Put another input in the place of the answer and evaluate it; keep the answer's residuals as evidence.

        Args:
            u_plus: The input, within the limits, shape (m,).
            solver: Name of where it comes from.
            attempt: The attempt in whose place it is sent.
        """
        block, evidence = self._block, attempt.assessment
        block.answer_numbers.fill(0.0)
        block.answer.z[: len(u_plus)] = u_plus - block.program.u_ref
        self._functions.evaluate()
        block.evaluation.u_plus[:] = u_plus
        residuals = block.residuals
        residuals.primal[:], residuals.dual[:], residuals.gap[:] = evidence.primal, evidence.dual, evidence.gap
        return Attempt(attempt.status, solver, False, block.read_assessment())
