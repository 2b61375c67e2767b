import gc
import struct

import casadi as ca
import numpy as np
import pytest

from passafe.numerics.workspace import BlockLayout, Workspace, dense_function

LAYOUT = BlockLayout.of({"a": 2, "nothing": 0, "b": 3, "c": (2, 3)})


def test_parts_lie_one_after_the_other() -> None:
    assert dict(LAYOUT.parts) == {
        "a": slice(0, 2),
        "nothing": slice(2, 2),
        "b": slice(2, 5),
        "c": slice(5, 11),
    }
    assert list(LAYOUT.parts) == ["a", "nothing", "b", "c"]
    assert LAYOUT.size == 11
    assert BlockLayout.of({}).size == 0


def test_a_span_holds_neighbours_in_their_order() -> None:
    assert LAYOUT.span(("a", "nothing", "b")) == slice(0, 5)
    for names in (("a", "c"), ("b", "a")):
        with pytest.raises(ValueError, match="allowed parts one after the other"):
            LAYOUT.span(names)


def test_parts_cannot_be_moved() -> None:
    with pytest.raises(TypeError):
        LAYOUT.parts["a"] = slice(0, 1)  # type: ignore[index]  # that it is refused is the point


def test_parts_and_matrices_are_views() -> None:
    space = Workspace(LAYOUT)
    matrix = space.view("c")
    space.block[:] = np.arange(11.0)

    assert space.part("b").tolist() == [2, 3, 4]
    assert matrix.tolist() == [[5, 7, 9], [6, 8, 10]]
    assert matrix.flags.f_contiguous
    matrix[0, 1] = -1
    assert space.block[7] == -1


def test_bound_function_reads_and_writes_its_parts_only() -> None:
    space = Workspace(LAYOUT)
    a, b = ca.SX.sym("a", 2), ca.SX.sym("b", 3)
    outer = dense_function("outer", [a, b], [a @ b.T])
    evaluate = space.bind(outer, ["a", "b"], ["c"])
    for scale in (1.0, -2.0):
        space.part("a")[:] = [scale, 2 * scale]
        space.part("b")[:] = [3, 4, 5]
        evaluate()

        assert space.view("c").tolist() == [
            [3 * scale, 4 * scale, 5 * scale],
            [6 * scale, 8 * scale, 10 * scale],
        ]
        assert space.block[:5].tolist() == [scale, 2 * scale, 3, 4, 5]


def test_structural_zeros_are_written_too() -> None:
    space = Workspace(LAYOUT)
    a = ca.SX.sym("a", 2)
    evaluate = space.bind(dense_function("diagonal", [a], [ca.vertcat(ca.SX(1, 1), a)]), ["a"], ["b"])
    space.block[:] = 7.0
    evaluate()

    assert space.part("b").tolist() == [0, 7, 7]


def test_parts_without_numbers_can_be_bound() -> None:
    space = Workspace(LAYOUT)
    a, nothing = ca.SX.sym("a", 2), ca.SX.sym("nothing", 0)
    evaluate = space.bind(dense_function("twice", [a, nothing], [2 * a, nothing]), ["a", "nothing"], ["a", "nothing"])
    space.part("a")[:] = [1, 2]
    evaluate()

    assert space.part("a").tolist() == [2, 4]


def test_a_workspace_keeps_what_casadi_does_not() -> None:
    """The buffer holds bare addresses only; the function must outlive every name of it that the caller drops."""
    space = Workspace(LAYOUT)
    a = ca.SX.sym("a", 2)
    evaluate = space.bind(dense_function("sum", [a], [ca.vertcat(a, ca.sum1(a))]), ["a"], ["b"])
    del a
    gc.collect()
    churn = [np.full(1000, 9.0) for _ in range(100)]
    space.part("a")[:] = [1, 2]
    evaluate()

    assert space.part("b").tolist() == [1, 2, 3]
    assert len(churn) == 100


@pytest.mark.parametrize(
    ("arguments", "results", "message"),
    [
        (["b"], ["a"], "twice b: got 3 numbers, allowed a dense part of 2"),
        (["nothing"], ["a"], "twice nothing: got 0 numbers, allowed a dense part of 2"),
        (["a"], ["nothing"], "twice nothing: got 0 numbers, allowed a dense part of 2"),
        (["a"], ["c"], "twice c: got 6 numbers, allowed a dense part of 2"),
        (["a"], ["a", "a"], "argument"),
        (["a"], [], "argument"),
    ],
)
def test_parts_that_do_not_fit_are_refused(arguments: list[str], results: list[str], message: str) -> None:
    a = ca.SX.sym("a", 2)

    with pytest.raises(ValueError, match=message):
        Workspace(LAYOUT).bind(dense_function("twice", [a], [2 * a]), arguments, results)


def test_sparse_results_are_refused() -> None:
    a = ca.SX.sym("a", 2)
    sparse = ca.Function("sparse", [a], [ca.vertcat(a[0], ca.SX(1, 1))])

    with pytest.raises(ValueError, match="sparse a: got 2 numbers, allowed a dense part of 2"):
        Workspace(LAYOUT).bind(sparse, ["a"], ["a"])


def test_writers_and_readers_take_the_numbers_of_one_part() -> None:
    space = Workspace(LAYOUT)
    space.writer("b")(3, 4, 5)

    assert space.block[:5].tolist() == [0, 0, 3, 4, 5]
    assert space.reader("b")() == (3.0, 4.0, 5.0)
    with pytest.raises(struct.error):
        space.writer("b")(3, 4)
    assert space.reader("nothing")() == ()
