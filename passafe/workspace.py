"""One block of numbers with named parts, and CasADi functions that read and write it without allocating."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import cast

import casadi as ca
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, slots=True)
class BlockLayout:
    """Where each named part of a block lies.

    Attributes:
        parts: Slice of every part, in the order in which they were named.
        size: Length of the block.
    """

    parts: Mapping[str, slice]
    size: int

    @classmethod
    def of(cls, sizes: Mapping[str, int]) -> "BlockLayout":
        """Lay parts of the given sizes one after the other."""
        parts: dict[str, slice] = {}
        start = 0
        for name, size in sizes.items():
            parts[name] = slice(start, start + size)
            start += size
        return cls(parts=MappingProxyType(parts), size=start)


class Workspace:
    """A block of doubles; its parts are views, so that whoever holds one sees every change.

    Attributes:
        layout: Names and places of the parts.
        block: The numbers, shape (layout.size,).
        memory: The same numbers for ``struct``, which reads and writes a few of them faster than numpy.
    """

    def __init__(self, layout: BlockLayout) -> None:
        self.layout = layout
        self.block: Array = np.zeros(layout.size)
        self.memory: memoryview = self.block.data
        self._kept_alive: list[object] = []

    def part(self, name: str) -> Array:
        """Return the view of one part, shape (size of the part,)."""
        return self.block[self.layout.parts[name]]

    def matrix(self, name: str, shape: tuple[int, int]) -> Array:
        """Return the view of one part as a Fortran-ordered matrix, as CasADi and PIQP have them."""
        return self.part(name).reshape(shape, order="F")

    def bind(self, function: ca.Function, arguments: Sequence[str], results: Sequence[str]) -> Callable[[], None]:
        """Tie a function to parts of the block and return what evaluates it, without arguments or allocation.

        CasADi's buffer keeps bare addresses: the workspace holds the function and the buffer from now on, and must
        itself be held for as long as the returned callable is used, or it writes into freed memory.

        Args:
            function: Dense inputs and outputs of the parts' sizes.
            arguments: Part read for each input.
            results: Part written for each output.

        Raises:
            ValueError: A part's size is not that of the function's argument or result.
        """
        buffer, evaluate = function.buffer()
        inputs = [function.sparsity_in(i) for i in range(function.n_in())]
        outputs = [function.sparsity_out(i) for i in range(function.n_out())]
        for i, (name, sparsity) in enumerate(zip(arguments, inputs, strict=True)):
            memory = self._fitting(name, function, sparsity)
            if memory.nbytes:
                buffer.set_arg(i, memory)  # type: ignore[call-arg] # stub of the C++ call
        for i, (name, sparsity) in enumerate(zip(results, outputs, strict=True)):
            memory = self._fitting(name, function, sparsity)
            if memory.nbytes:
                buffer.set_res(i, memory)  # type: ignore[call-arg] # stub of the C++ call
        self._kept_alive += [function, buffer]
        return cast(Callable[[], None], evaluate)

    def _fitting(self, name: str, function: ca.Function, sparsity: ca.Sparsity) -> memoryview:
        """Return the memory of a part, if it has the size that the function wants."""
        array = self.part(name)
        if not sparsity.is_dense() or sparsity.numel() != array.size:
            wanted = f"a dense part of {sparsity.numel()}"
            raise ValueError(f"{function.name()} {name}: got {array.size} numbers, allowed {wanted}")
        return array.data


def dense_function(name: str, arguments: Sequence[ca.SX], results: Sequence[ca.SX]) -> ca.Function:
    """Return a CasADi function whose results are dense, as buffers need them."""
    return ca.Function(name, list(arguments), [ca.densify(result) for result in results], {"cse": True})
