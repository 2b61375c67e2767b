"""Ages of what the page shows, by content: since it was measured or made, not since it arrived."""

from typing import Any, Final

from passafe_protocol.topics import TICK

from passafe_dashboard.live.feed import Feed

READ_S: Final = 0.1
"""The robot may have an input of a tick that is not read here yet; one much later is of a filter that ended."""


def ages(feed: Feed, now_ns: int) -> dict[str, float | None]:
    """Return delays and ages, ms; null where they are not known.

    Args:
        feed: The feed.
        now_ns: This process's monotonic clock.

    Returns:
        ``state_ms``: age now of the state that the newest decision rests on. ``from_robot_ms``: its age at the
        decision, which is the way from the robot. ``to_robot_ms``: the way of the newest input to the robot, to a
        period. ``round_trip_ms``: both. ``command_ms``: age of the operator's command at the decision.
    """
    tick, state = feed.run.tick, feed.run.state
    found: dict[str, Any] = dict.fromkeys(("state_ms", "from_robot_ms", "to_robot_ms", "round_trip_ms", "command_ms"))
    if tick is None:
        return found
    if tick.command_age_ns >= 0:
        found["command_ms"] = tick.command_age_ns * 1e-6
    if tick.state_age_ns >= 0:
        found["from_robot_ms"] = tick.state_age_ns * 1e-6
        monitor = feed.topic_monitors.get((TICK.publishers[0], TICK.name))
        shown_for_s = 0.0 if monitor is None else monitor.age_s(now_ns)
        found["state_ms"] = found["from_robot_ms"] + shown_for_s * 1e3
    if state is None or feed.scenario is None or not state.received_tick:
        return found
    way_s = (tick.tick - state.received_tick) * feed.scenario.dt_s
    if way_s > -READ_S:
        found["to_robot_ms"] = max(way_s, 0.0) * 1e3
        if found["from_robot_ms"] is not None:
            found["round_trip_ms"] = found["from_robot_ms"] + found["to_robot_ms"]
    return found
