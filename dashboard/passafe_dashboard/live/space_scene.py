"""Describe the live scene of a robot in space: its links, and the balls and levels that it keeps off."""

from typing import Any

from passafe_services.scenarios.barrier_kinds.body_spheres import BallBarrier, LevelBarrier
from passafe_services.scenarios.body_in_space import BodyInSpace
from passafe_services.scenarios.schema import Scenario

ROOM_M = 0.15
"""Room around what is in view, m."""


def space_scene(scenario: Scenario, body: BodyInSpace) -> dict[str, Any]:
    """Return the scene as JSON values; ``bounds`` are the corners of what is in view at the start."""
    balls = {
        (each.centre, each.radius): _owner(each.name) for each in scenario.barriers if isinstance(each, BallBarrier)
    }
    levels = {each.height_m: _owner(each.name) for each in scenario.barriers if isinstance(each, LevelBarrier)}
    points, centres = body.at(scenario.plant.x0)
    discs = [*zip(centres, body.radii, strict=True), *balls, *((point, 0.0) for point in points)]
    low = tuple(min(centre[i] - radius for centre, radius in discs) - ROOM_M for i in range(3))
    high = tuple(max(centre[i] + radius for centre, radius in discs) + ROOM_M for i in range(3))
    floor = min([low[2], *(height - ROOM_M for height in levels)])
    return {
        "kind": "space",
        "links": body.links,
        "radii": body.radii,
        "balls": [{"name": name, "centre": centre, "radius": radius} for (centre, radius), name in balls.items()],
        "levels": [{"name": name, "height_m": height} for height, name in levels.items()],
        "bounds": ((*low[:2], floor), high),
    }


def _owner(name: str) -> str:
    """Return the name of the barrier in the scenario, without the sphere that it is about."""
    return name.partition(":")[0]
