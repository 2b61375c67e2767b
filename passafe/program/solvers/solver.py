"""The protocol of a solver of min ½‖z‖² subject to G z ≥ d, for arrays that change in place."""

from enum import Enum
from typing import Protocol


class SolverOutcome(Enum):
    """Outcome that a solver reports; the certificate decides whether the answer is used."""

    SOLVED = "solved"
    INFEASIBLE = "infeasible"
    FAILED = "failed"


SOLVED, INFEASIBLE, FAILED = SolverOutcome


class Solver(Protocol):
    """Holds G and d from its making on and reads them again at every solve.

    An answer is a function of the present G and d alone: no solver starts from what it found before.

    Attributes:
        name: How the certificate names it.
    """

    name: str

    def solve(self, z: memoryview, lam: memoryview) -> SolverOutcome:
        """Solve for the present G and d.

        Args:
            z: Receives the decision, k numbers. Whatever the outcome, it may hold anything.
            lam: Receives the multipliers, N numbers.

        Returns:
            The outcome that the solver reports.
        """
        ...
