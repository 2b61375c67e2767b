"""Rows of which a review knows whether they were active."""

import numpy as np
import pytest
from passafe_services.tools.review.explanation_check import is_sure


@pytest.mark.parametrize(
    ("push", "share", "logged_active", "logged_share", "sure"),
    [
        (0.0, 0.0, False, 0.0, True),
        (0.0, 0.0, True, 0.0, True),
        (0.0, 0.0, True, 1e-5, False),
        (0.0, 0.0, True, 0.1, True),
        (3e-4, 1e-5, False, 0.0, False),
        (3e-4, 0.1, False, 0.0, True),
        (3e-4, 1e-5, True, 1e-5, True),
        (2e-6, 0.1, True, 0.1, False),
    ],
)
def test_slight_push_is_what_two_accepted_answers_differ_by(
    push: float, share: float, *, logged_active: bool, logged_share: float, sure: bool
) -> None:
    found = is_sure(np.array([[push]]), np.array([[share]]), np.array([[logged_active]]), np.array([[logged_share]]))

    assert found.tolist() == [[sure]]
