"""Pushes that a parallel row may have as well: of these no log is accused."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from passafe_services.tools.review.parallel_pushes import pushed_alike


def batch(*gradients: tuple[float, float], margins: tuple[float, ...], z: float) -> Any:  # noqa: ANN401 - what is read
    """Return one decision about two axes with a row for each gradient."""
    return SimpleNamespace(
        program=SimpleNamespace(G=np.array(gradients).T[:, :, None]),
        evaluation=SimpleNamespace(u_plus=np.zeros((2, 1)), margins=np.array(margins)[:, None]),
        core=SimpleNamespace(design=SimpleNamespace(tolerance=SimpleNamespace(gap=1e-6))),
        part=lambda _name: np.array([[z]]),
    )


@pytest.mark.parametrize(
    ("second", "margin", "z", "alike"),
    [
        ((0.6, 0.8), 1e-6, 0.0, True),
        ((0.6, 0.8), 0.3, 0.0, False),  # with a push of 0.5 the certificate would not have accepted it
        ((0.6, 0.8), 0.3, 400.0, True),
        ((-0.6, -0.8), 1e-6, 0.0, False),
        ((0.8, 0.6), 1e-6, 0.0, False),
    ],
)
def test_rows_that_may_push_along_one_direction(
    second: tuple[float, float], margin: float, z: float, *, alike: bool
) -> None:
    decided = batch((0.6, 0.8), second, (0.0, 1.0), margins=(0.0, margin, 0.0), z=z)
    dual = np.array([[0.5], [0.5], [0.0]])

    assert pushed_alike(decided, dual)[:, 0].tolist() == [alike, alike, False]
