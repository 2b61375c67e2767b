"""Rows in order of plant time, by times written down."""

import numpy as np
from passafe_services.tools.review.time_order import PATIENCE_NS, TimeOrder

S = 1_000_000_000


def row(*values: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.array([values])


def test_rows_are_released_in_order_after_the_patience() -> None:
    order = TimeOrder(1)

    early, _ = order.take(np.array([0, 2 * S, 1 * S]), row(0, 2, 1))
    later, values = order.take(np.array([3 * S, 5 * S]), row(3, 5))
    rest, _ = order.finish()

    assert early.size == 0
    assert later.tolist() == [0, S, 2 * S]
    assert values.tolist() == [[0, 1, 2]]
    assert rest.tolist() == [3 * S, 5 * S]
    assert order.out_of_order == 0


def test_equal_times_stay_as_they_came() -> None:
    order = TimeOrder(1)
    order.take(np.array([5, 5, 3]), row(1, 2, 3))

    assert order.finish()[1].tolist() == [[3, 1, 2]]


def test_what_comes_after_its_time_is_counted() -> None:
    order = TimeOrder(1)
    order.take(np.array([0, 2 * PATIENCE_NS]), row(0, 1))
    order.take(np.array([-1, 3 * PATIENCE_NS]), row(2, 3))

    assert order.out_of_order == 1
