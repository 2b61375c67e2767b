"""One block of numbers with named parts, and CasADi functions that read and write it without allocating."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from math import prod
from struct import Struct
from types import MappingProxyType
from typing import TypeAlias, TypeVar, cast, get_origin

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from passafe.numerics.stage import Stage

Array = NDArray[np.float64]

Writer: TypeAlias = Callable[..., None]
"""Writes a part; its arguments are the part's numbers, as many as it has."""

Compiler: TypeAlias = Callable[[ca.Function], ca.Function]
"""Returns the same function in another form, such as machine code."""

Scalars = TypeVar("Scalars", bound=Stage[float])


@dataclass(frozen=True, kw_only=True, slots=True)
class BlockLayout:
    """Places and shapes of the named parts of a block.

    Attributes:
        parts: Slice of every part, in the order in which they were named.
        shapes: Shape of every part: (size,), or (rows, columns) of a matrix, which lies column by column.
        size: Length of the block.
    """

    parts: Mapping[str, slice]
    shapes: Mapping[str, tuple[int, ...]]
    size: int

    @classmethod
    def of(cls, shapes: Mapping[str, int | tuple[int, ...]]) -> "BlockLayout":
        """Lay parts of the given sizes or shapes one after the other."""
        parts: dict[str, slice] = {}
        full: dict[str, tuple[int, ...]] = {}
        start = 0
        for name, shape in shapes.items():
            full[name] = (shape,) if isinstance(shape, int) else shape
            parts[name] = slice(start, start + prod(full[name]))
            start = parts[name].stop
        return cls(parts=MappingProxyType(parts), shapes=MappingProxyType(full), size=start)

    @classmethod
    def of_stages(cls, *stages: Stage[ca.SX]) -> "BlockLayout":
        """Lay the parts of stages, shaped as their expressions, one after the other in the order of declaration.

        Raises:
            ValueError: A name is in two stages.
        """
        shapes: dict[str, int | tuple[int, ...]] = {}
        for stage in stages:
            matrices = stage.matrices()
            for name, expression in stage.fields().items():
                if name in shapes:
                    raise ValueError(f"parts of a block: got {name!r} twice, allowed each name once")
                shapes[name] = expression.shape if name in matrices else expression.numel()
        return cls.of(shapes)

    def span(self, names: Sequence[str]) -> slice:
        """Return the slice that holds some parts and nothing else.

        Raises:
            ValueError: They do not lie one after the other, in this order.
        """
        parts = [self.parts[name] for name in names]
        if any(before.stop != after.start for before, after in pairwise(parts)):
            raise ValueError(f"span of parts: got {list(names)}, allowed parts one after the other: {list(self.parts)}")
        return slice(parts[0].start, parts[-1].stop)

    def view(self, block: Array, name: str) -> Array:
        """Return the view of one part of a block: a vector, or a matrix in Fortran order, as CasADi has them."""
        return block[self.parts[name]].reshape(self.shapes[name], order="F")


class Workspace:
    """A block of doubles; its parts are views, so that whoever holds one sees every change.

    Attributes:
        layout: Names and places of the parts.
        block: The numbers, shape (layout.size,).
    """

    def __init__(self, layout: BlockLayout) -> None:
        self.layout = layout
        self.block: Array = np.zeros(layout.size)
        self._kept_alive: list[object] = []

    def part(self, name: str) -> Array:
        """Return the view of one part, shape (size of the part,)."""
        return self.block[self.layout.parts[name]]

    def view(self, name: str) -> Array:
        """Return the view of one part: a vector, or a Fortran-ordered matrix."""
        return self.layout.view(self.block, name)

    def writer(self, name: str) -> Writer:
        """Return what writes one part from its numbers, faster than numpy does."""
        return self.span_writer((name,))

    def span_writer(self, names: Sequence[str]) -> Writer:
        """Return what writes parts that lie one after the other from all their numbers.

        Raises:
            ValueError: They do not.
        """
        part = self.block[self.layout.span(names)]
        return partial(Struct(f"{part.size}d").pack_into, part.data, 0)

    def reader(self, name: str) -> Callable[[], tuple[float, ...]]:
        """Return what reads the numbers of one part, faster than numpy does."""
        part = self.part(name)
        return partial(Struct(f"{part.size}d").unpack_from, part.data)

    def scalar_reader(self, stage: type[Scalars]) -> Callable[[], Scalars]:
        """Return what reads a stage all of whose parts are single numbers.

        Raises:
            ValueError: They are not, or do not lie in the order of the stage's declaration.
        """
        names = stage.names()
        memory = self.block[self.layout.span(names)].data
        if memory.shape != (len(names),) or any(self.part(name).size != 1 for name in names):
            raise ValueError(f"reader of {names}: got {memory.shape} numbers, allowed one for each name")
        unpack = Struct(f"{len(names)}d").unpack_from
        make = cast(Callable[..., Scalars], get_origin(stage) or stage)

        def read() -> Scalars:
            return make(*unpack(memory))

        return read

    def bind(
        self, function: ca.Function, arguments: Sequence[str] | None = None, results: Sequence[str] | None = None
    ) -> Callable[[], None]:
        """Tie a function to parts of the block and return what evaluates it, without arguments or allocation.

        CasADi's buffer keeps bare addresses: the workspace holds the function and the buffer from now on, and must
        itself be held for as long as the returned callable is used, or it writes into freed memory.

        Args:
            function: Dense inputs and outputs of the parts' sizes.
            arguments: Part read for each input; by default the one that the input is named for.
            results: Part written for each output; by default the one that the output is named for.

        Raises:
            ValueError: A part's size is not that of the function's argument or result.
        """
        buffer, evaluate = function.buffer()
        inputs = [function.sparsity_in(i) for i in range(function.n_in())]
        outputs = [function.sparsity_out(i) for i in range(function.n_out())]
        arguments = function.name_in() if arguments is None else arguments
        results = function.name_out() if results is None else results
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


def interpreted(function: ca.Function) -> ca.Function:
    """Return a function as it is, run by CasADi's virtual machine."""
    return function


def dense_function(name: str, arguments: Sequence[ca.SX], results: Sequence[ca.SX]) -> ca.Function:
    """Return a CasADi function whose results are dense, as buffers need them."""
    return ca.Function(name, list(arguments), [ca.densify(result) for result in results], {"cse": True})


def named_function(name: str, arguments: Mapping[str, ca.SX], results: Mapping[str, ca.SX]) -> ca.Function:
    """Return a function with dense results whose inputs and outputs are named, so that a workspace can bind it."""
    dense = [ca.densify(result) for result in results.values()]
    return ca.Function(name, list(arguments.values()), dense, list(arguments), list(results), {"cse": True})


def expressions_by_name(*stages: Stage[ca.SX]) -> dict[str, ca.SX]:
    """Return the expressions of stages by the names of their parts, in the order of declaration."""
    return {name: expression for stage in stages for name, expression in stage.fields().items()}


def expressions(stage: Stage[ca.SX]) -> list[ca.SX]:
    """Return a stage's expressions in the order of its declaration."""
    return list(stage.fields().values())
