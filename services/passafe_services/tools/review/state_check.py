"""Check of the plant's states against the model: outputs, stored energy, energy supplied, and phases."""

from typing import Final

import numpy as np

from passafe_services.log.message_block import MessageBlock
from passafe_services.tools.review.agreement import LogAgreement, relative
from passafe_services.tools.review.plant_evaluator import FloatArray, PlantEvaluator
from passafe_services.tools.review.trajectory import NS_PER_S, Trajectory

ROUNDING: Final = 1e-9
"""Relative difference that rounding may leave between the plant's own numbers and recomputed ones."""


class StateCheck:
    """Check of the states of a run, as they come.

    Args:
        evaluator: Functions of the scenario.
        is_exact: Whether the plant is its model; else the energy supplied does not follow from states and inputs.

    Attributes:
        agreement: Differences.
    """

    def __init__(self, evaluator: PlantEvaluator, *, is_exact: bool = True) -> None:
        self._evaluator = evaluator
        self._is_exact = is_exact
        self.agreement = LogAgreement(
            "outputs, energies, phases and counts of states that do not follow from the others = 0"
        )

    def take_states(self, block: MessageBlock, x: FloatArray) -> None:
        """Take states as they were sent, with their x, shape (n, N)."""
        at_s = block.numbers("plant_ns") / NS_PER_S
        sequence = block.sequence
        with np.errstate(over="ignore", invalid="ignore"):
            y, stored = self._evaluator.output(x), self._evaluator.stored(x)
        given = block.ragged("y")
        logged = given.matrix(y.shape[0]).T

        def name(row: int) -> str:
            return f"state {int(sequence[row])}"

        self.agreement.compare("output y", relative(logged, y), at_s, ROUNDING, name)
        stored_j = block.numbers("energy_stored_j")
        self.agreement.compare("stored energy", relative(stored_j[None], stored[None]), at_s, ROUNDING, name)
        if not int(sequence[0]):
            started = np.abs(block.numbers("energy_in_j")[:1])
            self.agreement.compare("energy supplied at the start", started, at_s[:1], 0.0, name)

    def take_motion(self, trajectory: Trajectory) -> None:
        """Take samples that follow one another."""
        if not self._is_exact:
            return
        for period_s in np.unique(trajectory.period_s[trajectory.period_s > 0]):
            (begun,) = np.nonzero(trajectory.period_s == period_s)
            with np.errstate(over="ignore", invalid="ignore"):
                supplied = self._evaluator.supplied(trajectory.x[:, begun], trajectory.u[:, begun], float(period_s))
            before, after = trajectory.energy_in_j[begun], trajectory.energy_in_j[begun + 1]
            at_s = trajectory.t_s[begun + 1]
            difference = relative(after[None], (before + supplied)[None])

            def name(row: int, at_s: FloatArray = at_s) -> str:
                return f"state at {at_s[row]:.3f} s"

            self.agreement.compare("energy supplied", difference, at_s, ROUNDING, name)
