"""Pushes that a parallel row may have as well: of these no log is accused."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from passafe_services.tools.review.parallel_pushes import pushed_alike


def batch(*gradients: tuple[float, float], margins: tuple[float, ...]) -> Any:  # noqa: ANN401 - what is read of one
    """Return one decision about two axes with a row for each gradient."""
    program = SimpleNamespace(G=np.array(gradients).T[:, :, None])
    evaluation = SimpleNamespace(u_plus=np.zeros((2, 1)), margins=np.array(margins)[:, None])
    return SimpleNamespace(program=program, evaluation=evaluation, constraints=len(gradients))


@pytest.mark.parametrize(
    ("second", "margins", "alike"),
    [
        ((0.6, 0.8), (0.0, 0.003), True),
        ((0.6, 0.8), (0.0, 0.1), False),  # the other does not bind
        ((-0.6, -0.8), (0.0, 0.0), False),
        ((0.8, 0.6), (0.0, 0.0), False),
    ],
)
def test_rows_that_bind_along_one_direction(
    second: tuple[float, float], margins: tuple[float, float], *, alike: bool
) -> None:
    found = pushed_alike(batch((0.6, 0.8), second, (0.0, 1.0), margins=(*margins, 0.0)), 1)

    assert found[:, 0].tolist() == [alike, alike, False]
