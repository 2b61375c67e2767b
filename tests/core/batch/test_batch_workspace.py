import casadi as ca
import numpy as np
import pytest

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.errors import DesignError
from passafe.numerics.workspace import BlockLayout, dense_function


@pytest.mark.parametrize(("used", "count"), [(1, 8), (8, 8), (9, 16), (1000, 1000)])
def test_there_are_whole_vectors_of_elements(used: int, count: int) -> None:
    batch = BatchWorkspace(BlockLayout.of({"x": 2}), used)

    assert (batch.used, batch.count) == (used, count)
    assert batch.part("x").shape == (2, count)


def test_a_matrix_has_its_columns_first() -> None:
    batch = BatchWorkspace(BlockLayout.of({"before": 1, "G": (3, 2)}), 8)
    batch.part("G")[:, 3] = np.arange(6)

    assert batch.view("G")[:, :, 3].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_a_bound_function_is_evaluated_for_every_element() -> None:
    a = ca.SX.sym("a", 2)
    batch = BatchWorkspace(BlockLayout.of({"a": 2, "f": 1}), 3)
    batch.part("a")[:, :3] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]

    batch.bind(dense_function("f", [a], [a[0] * a[1]]), ["a"], ["f"])()

    assert batch.part("f")[0, :3].tolist() == [4.0, 10.0, 18.0]


def test_an_operation_that_arrays_do_not_know_is_refused() -> None:
    a = ca.SX.sym("a")
    batch = BatchWorkspace(BlockLayout.of({"a": 1, "f": 1}), 1)

    with pytest.raises(DesignError, match="got the operation OP_ERF"):
        batch.bind(dense_function("f", [a], [ca.erf(a)]), ["a"], ["f"])
