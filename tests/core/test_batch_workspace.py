import casadi as ca
import numpy as np
import pytest

from passafe.batch.batch_workspace import BatchWorkspace
from passafe.errors import DesignError
from passafe.workspace import BlockLayout, dense_function


@pytest.mark.parametrize(("used", "count"), [(1, 8), (8, 8), (9, 16), (1000, 1000)])
def test_there_are_whole_vectors_of_lanes(used: int, count: int) -> None:
    lanes = BatchWorkspace(BlockLayout.of({"x": 2}), used)

    assert (lanes.used, lanes.count) == (used, count)
    assert lanes.part("x").shape == (2, count)


def test_a_matrix_has_its_columns_first() -> None:
    lanes = BatchWorkspace(BlockLayout.of({"before": 1, "G": (3, 2)}), 8)
    lanes.part("G")[:, 3] = np.arange(6)

    assert lanes.view("G")[:, :, 3].tolist() == [[0, 1, 2], [3, 4, 5]]


def test_a_bound_function_is_evaluated_for_every_lane() -> None:
    a = ca.SX.sym("a", 2)
    lanes = BatchWorkspace(BlockLayout.of({"a": 2, "f": 1}), 3)
    lanes.part("a")[:, :3] = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]

    lanes.bind(dense_function("f", [a], [a[0] * a[1]]), ["a"], ["f"])()

    assert lanes.part("f")[0, :3].tolist() == [4.0, 10.0, 18.0]


def test_an_operation_that_arrays_do_not_know_is_refused() -> None:
    a = ca.SX.sym("a")
    lanes = BatchWorkspace(BlockLayout.of({"a": 1, "f": 1}), 1)

    with pytest.raises(DesignError, match="got the operation OP_ERF"):
        lanes.bind(dense_function("f", [a], [ca.erf(a)]), ["a"], ["f"])
