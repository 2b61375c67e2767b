"""Many plants of one kind, each under an input of its own that is held: what ``SampledPlant`` is for one."""

import numpy as np

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.numerics.workspace import Array
from passafe.sampled_plant import LOCAL_TOLERANCE, SampledPlant


class BatchPlant:
    """Steps plants over periods in which their inputs are constant.

    Attributes:
        plant: What each of them is.
        batch: Parts x and u before the period, x_next, y, stored, energy and error after it; a column for each plant.
    """

    def __init__(self, plant: SampledPlant, count: int) -> None:
        """Bind the step.

        Args:
            plant: What each of them is.
            count: How many.

        Raises:
            DesignError: The dynamics have an operation that arrays do not know.
        """
        self.plant = plant
        self.batch = batch = BatchWorkspace(plant.layout, count)
        self._step = batch.bind(plant.step)

    def advance(self, x: Array, u: Array) -> None:
        """Write the plants one period later; a step that misses its accuracy is done again as ``SampledPlant`` does it.

        Args:
            x: States at the beginning, shape (n, count).
            u: Inputs held over the period, shape (m, count).

        Raises:
            IntegrationError: A nonlinear plant's step missed its accuracy even with the most substeps.
        """
        used, first = self.batch.used, self.batch.layout.parts["x_next"].start
        before, held, error = (self.batch.part(name)[:, :used] for name in ("x", "u", "error"))
        before[:], held[:] = x, u
        self.batch.part("h").fill(self.plant.dt_s)
        self._step()
        for element in np.flatnonzero(~(error[0] <= LOCAL_TOLERANCE)).tolist():
            sample = self.plant.advance(before[:, element].tolist(), held[:, element].tolist())
            after = (*sample.x, *sample.y, sample.stored_j, sample.energy_in_j, sample.integration_error)
            self.batch.block[first:, element] = after
