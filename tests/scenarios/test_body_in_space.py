"""A robot in space as numbers: the arm's links keep their lengths, spheres are where the core has them."""

from math import dist, inf

import casadi as ca
import pytest
from passafe_services.scenarios.body_in_space import BodyInSpace
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.load import load_scenario


def test_links_keep_their_lengths_in_every_posture() -> None:
    scenario = load_scenario("arm-over-table")
    body = BodyInSpace.of(robot_of(scenario))
    assert body is not None
    moved = [angle + 0.3 * (-1) ** i for i, angle in enumerate(scenario.plant.x0)]

    postures = [body.at(x)[0] for x in (scenario.plant.x0, moved)]

    lengths = [[dist(points[i], points[j]) for i, j in body.links] for points in postures]
    assert lengths[0] == pytest.approx(lengths[1])
    assert postures[0][-1] != pytest.approx(postures[1][-1])


def test_spheres_are_where_the_core_has_them() -> None:
    scenario = load_scenario("arm-over-table")
    robot = robot_of(scenario)
    body = BodyInSpace.of(robot)
    assert body is not None

    _, centres = body.at(scenario.plant.x0)

    assert len(centres) == len(robot.spheres) == len(body.radii)
    for sphere, centre in zip(robot.spheres, centres, strict=True):
        expected = ca.Function("c", [robot.system.x], [sphere.centre])(list(scenario.plant.x0))
        assert centre == pytest.approx(expected.elements())
        assert min(body.radii) <= sphere.radius_m < inf


def test_robots_of_the_plane_have_no_body_in_space() -> None:
    assert BodyInSpace.of(robot_of(load_scenario("unicycle-posts"))) is None
    assert BodyInSpace.of(robot_of(load_scenario("two-robots"))) is None
