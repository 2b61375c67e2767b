"""Describe the live scene once a scenario: outlines, the part of the plane to show, joints with their limits."""

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from passafe_services.scenarios.barrier_kinds.outline import Outline
from passafe_services.scenarios.body_in_space import BodyInSpace
from passafe_services.scenarios.design import robot_of
from passafe_services.scenarios.drawn_places import DrawnPlaces
from passafe_services.scenarios.schema import Scenario

from passafe_dashboard.live.space_scene import space_scene
from passafe_dashboard.run_record.scene_payload import scene_payload
from passafe_dashboard.run_record.signals import SignalLayout

Box = tuple[tuple[float, float], tuple[float, float]]

OPEN_M: Final = 2.5
"""Half-width of the view along an axis without a wall on both sides, m."""

PERIOD_SAMPLES: Final = 200


def live_scene(scenario: Scenario) -> dict[str, Any]:
    """Return the scene as JSON values: of a robot in space, or that of a report and the bounds of the view."""
    robot = robot_of(scenario)
    body = BodyInSpace.of(robot)
    if body is not None:
        return space_scene(scenario, body)
    layout = SignalLayout.of(scenario, robot)
    scene = scene_payload(layout, scenario.plant.robot_model.position_unit)
    if layout.points:
        scene["bounds"] = _bounds(scenario)
    scene["velocities"] = robot.position.numel()
    return scene


def _bounds(scenario: Scenario) -> Box:
    """Return lowest and highest corner of the view: walls, bounded outlines wherever they move, the start."""
    outlines = [barrier.outline for barrier in scenario.barriers]
    places = [place for outline in outlines if outline is not None for place in _extent(outline)]
    places += DrawnPlaces.of(robot_of(scenario)).at(scenario.plant.x0)[0]
    walls = [outline for outline in outlines if outline is not None and not outline.is_closed]
    low, high = [], []
    for axis in range(2):
        values = [place[axis] for place in places]
        open_low = not any(wall.reference[axis] < 0 for wall in walls)
        open_high = not any(wall.reference[axis] > 0 for wall in walls)
        low.append(min([*values, *([-OPEN_M] if open_low else [])]))
        high.append(max([*values, *([OPEN_M] if open_high else [])]))
    return (low[0], low[1]), (high[0], high[1])


def _extent(outline: Outline) -> Iterator[tuple[float, float]]:
    """Yield corners of what must be in view; a wall is seen where it is nearest to the origin."""
    border = np.asarray(outline.border if outline.is_closed else [outline.reference]).T
    motion = outline.motion
    moved = np.zeros((2, 1))
    if motion is not None and motion.returns:
        moved = motion.displacements_m(np.linspace(0.0, _longest_period_s(outline), PERIOD_SAMPLES))
    yield tuple(border.min(axis=1) + moved.min(axis=1))
    yield tuple(border.max(axis=1) + moved.max(axis=1))


def _longest_period_s(outline: Outline) -> float:
    """Return the period of a motion that returns, s; that of a slow one is cut off at 1000 s."""
    frequency_hz = getattr(outline.motion, "frequency_hz", 0.0)
    return min(1.0 / frequency_hz, 1000.0) if frequency_hz else 1000.0
