"""Errors of shapes and models: field, value, allowed range."""

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest
from finite_differences import numeric

from passafe.barriers import box, disk_keep_out, ellipse_keep_out, separation, uniform_motion
from passafe.errors import DesignError, ShapeError
from passafe.models.joint_chain import joint_chain

p, space, t = ca.SX.sym("p", 2), ca.SX.sym("q", 3), ca.SX.sym("t")


@pytest.mark.parametrize(
    ("error", "words", "make"),
    [
        (DesignError, "every high above its low", lambda: box(p, low=[0.0, 1.0], high=[1.0, 1.0])),
        (ShapeError, "one for each coordinate", lambda: box(p, low=[0.0], high=[1.0])),
        (ShapeError, "a column", lambda: disk_keep_out(p.T, centre=[0.0, 0.0], radius=1.0)),
        (DesignError, "radius", lambda: disk_keep_out(p, centre=[0.0, 0.0], radius=-1.0)),
        (DesignError, "0 with 3", lambda: ellipse_keep_out(space, centre=[0] * 3, semi_axes=[1] * 3, rotation_rad=1.0)),
        (ShapeError, "two columns of equal length", lambda: separation(p, space, distance=1.0)),
        (ShapeError, "no numbers", lambda: uniform_motion(t, velocity=[])),
        (DesignError, "finite numbers", lambda: uniform_motion(t, velocity=[float("nan")])),
        (ShapeError, "a scalar", lambda: uniform_motion(p, velocity=[1.0])),
        (DesignError, "joints", lambda: joint_chain(joints=0)),
    ],
)
def test_what_makes_no_shape_is_refused(error: type[DesignError], words: str, make: Callable[[], object]) -> None:
    with pytest.raises(error, match=words):
        make()


def test_an_ellipse_without_rotation_is_the_plain_one() -> None:
    h = numeric([p], ellipse_keep_out(p, centre=[1.0, 0.0], semi_axes=[2.0, 1.0]))

    assert h(np.array([3.0, 0.0]))[0] == pytest.approx(0.0)
    assert h(np.array([1.0, 2.0]))[0] == pytest.approx(3.0)
