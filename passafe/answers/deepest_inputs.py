"""The admissible inputs that keep the hard rows best: of the program as it is posed, and of the rows themselves."""

from passafe.answers.input_search import InputSearch
from passafe.decision import Attempt
from passafe.numerics.workspace import Array
from passafe.program.decision_block import DecisionBlock
from passafe.program.infeasibility import DistanceToInfeasibility


class DeepestInputs:
    """Finds them for the decision that is being made.

    Attributes:
        search: Searches all admissible inputs; ``None`` where the rows are affine in u, and both kinds are one.
    """

    def __init__(self, block: DecisionBlock, distance: DistanceToInfeasibility, search: InputSearch | None) -> None:
        """Hold what they are found with.

        Args:
            block: Holds request, program and answer.
            distance: Solves for the first kind.
            search: Searches all admissible inputs, if the rows are not affine in u.
        """
        self.search, self._block, self._distance = search, block, distance

    def of_program(self, attempt: Attempt) -> Array:
        """Return the admissible input that keeps the hard rows best, as they are posed now, shape (m,).

        Args:
            attempt: The latest one.
        """
        return self._distance.deepest(self._block.decision(attempt))

    def of_rows(self) -> list[Array]:
        """Return the admissible input that keeps rows best which are not affine in u: tangents may not lead to it."""
        return [] if self.search is None else [self.search.deepest(self._block)]
