"""Blocks of a whole batch, on which CasADi functions are evaluated for all elements at once."""

from collections.abc import Callable, Sequence

import casadi as ca
import numpy as np

from passafe.batch.batch_function import BatchFunction, whole_vectors
from passafe.numerics.workspace import Array, BlockLayout


class BatchWorkspace:
    """A ``Workspace`` with one block, a column, for each element of a batch.

    Attributes:
        layout: Names and places of the parts.
        used: Number of elements.
        count: Number of columns: the elements, and a few that fill the last vector of the processor.
        block: The numbers, shape (layout.size, count).
    """

    def __init__(self, layout: BlockLayout, used: int) -> None:
        """Make room.

        Args:
            layout: Parts of every block.
            used: Number of elements.
        """
        self.layout = layout
        self.used = used
        self.count = whole_vectors(used)
        self.block: Array = np.zeros((layout.size, self.count))

    def part(self, name: str) -> Array:
        """Return the view of one part, shape (size of the part, count)."""
        return self.block[self.layout.parts[name]]

    def view(self, name: str) -> Array:
        """Return the view of one part in its shape: (size, count), or (columns, rows, count) of a matrix."""
        return self.part(name).reshape(*reversed(self.layout.shapes[name]), self.count)

    def bind(
        self, function: ca.Function, arguments: Sequence[str] | None = None, results: Sequence[str] | None = None
    ) -> Callable[[], None]:
        """Tie a function to parts of the blocks and return what evaluates it for all elements.

        Args:
            function: Dense inputs and outputs of the parts' sizes.
            arguments: Part read for each input; by default the one that the input is named for.
            results: Part written for each output, by default likewise; none of them is an argument.

        Raises:
            DesignError: The function has an operation that arrays do not know.
        """
        read = [self.part(name) for name in arguments or function.name_in()]
        written = [self.part(name) for name in results or function.name_out()]
        return BatchFunction(function).bind(read, written)
