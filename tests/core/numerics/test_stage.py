"""Names, order and shapes of a stage's parts follow from its declaration alone."""

import casadi as ca
import numpy as np
import pytest

from passafe.numerics.stage import Matrix, Stage, T, part_names
from passafe.numerics.workspace import Array, BlockLayout, Workspace, Writer, expressions


class Posed(Stage[T], frozen=True, eq=False, gc=False):
    A: Matrix[T]
    b: T


class Cost(Stage[T], frozen=True, eq=False, gc=False):
    value: T
    bound: T


class Turned(Stage[T], frozen=True, eq=False, gc=False):
    bound: T
    value: T


POSED = Posed(A=ca.SX.sym("A", 3, 1), b=ca.SX.sym("b", 3))
COST = Cost(value=ca.sumsqr(POSED.A), bound=POSED.b[1])


def test_a_layout_has_the_shapes_of_the_expressions() -> None:
    layout = BlockLayout.of_stages(POSED, COST)

    assert dict(layout.shapes) == {"A": (3, 1), "b": (3,), "value": (1,), "bound": (1,)}
    assert list(layout.parts) == part_names(Posed, Cost)
    with pytest.raises(ValueError, match="got 'A' twice, allowed each name once"):
        BlockLayout.of_stages(POSED, POSED)


def test_a_stage_is_made_from_its_names() -> None:
    assert Posed.of(str.upper).fields() == {"A": "A", "b": "B"}
    assert Posed.matrices() == {"A"}
    assert Cost.matrices() == frozenset()


def test_views_and_writers_reach_the_part_of_their_name() -> None:
    space = Workspace(BlockLayout.of_stages(POSED, COST))
    posed: Posed[Array] = Posed.of(space.view)
    write: Posed[Writer] = Posed.of(space.writer)
    write.A(1, 2, 3)
    write.b(4, 5, 6)

    assert posed.A.tolist() == [[1], [2], [3]]
    assert posed.b.tolist() == [4, 5, 6]


def test_scalars_are_read_into_the_fields_of_their_names() -> None:
    space = Workspace(BlockLayout.of_stages(POSED, COST))
    function = ca.Function("cost", expressions(POSED), expressions(COST))
    evaluate = space.bind(function, part_names(Posed), part_names(Cost))
    read = space.scalar_reader(Cost[float])
    space.block[:6] = np.arange(6.0)
    evaluate()
    cost = read()

    assert (cost.value, cost.bound) == (5.0, 4.0)


def test_a_reader_of_scalars_refuses_another_order_and_vectors() -> None:
    space = Workspace(BlockLayout.of_stages(POSED, COST))

    with pytest.raises(ValueError, match="allowed parts one after the other"):
        space.scalar_reader(Turned[float])
    with pytest.raises(ValueError, match="allowed one for each name"):
        space.scalar_reader(Posed[float])
