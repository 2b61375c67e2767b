"""Pushes of rows that a limit of the input may have as well: of these no log is accused."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from passafe_services.tools.review.limit_pushes import unlike_pull


def batch() -> Any:  # noqa: ANN401 - the parts of a batch filter that are read
    """Return three decisions about two axes with one row each: free, at a low limit, at a high one."""
    u = np.array([[0.5, 0.0, 0.5], [0.5, 0.5, 1.0]])
    gradients = np.repeat(np.eye(2)[:, :, None], 3, axis=2)
    program = SimpleNamespace(G=gradients, low=np.zeros((2, 3)), high=np.ones((2, 3)))
    return SimpleNamespace(program=program, evaluation=SimpleNamespace(u_plus=u))


def test_pull_counts_where_no_limit_takes_it() -> None:
    difference = np.array([[0.1, 0.1, 0.1], [0.0, 0.0, 0.1]])

    assert unlike_pull(batch(), difference, np.ones((2, 3))).tolist() == [0.05, 0.0, 0.05]
    assert unlike_pull(batch(), difference, -np.ones((2, 3))).tolist() == [0.5, 0.5, 0.5]
