"""Turn the feed into JSON values: the answer of ``/api/status``, and ``now`` in each frame of the page.

Numbers carry their unit in their name; an unknown value is null.
"""

from collections.abc import Mapping
from math import hypot
from typing import Any, Final, TypeAlias

from passafe_protocol.link_effect import LinkCounts
from passafe_protocol.messages import FilterTick, OperatorLease, PlantState
from passafe_protocol.shapes import as_dict
from passafe_protocol.topics import HEALTH, LINKS, PROCESSES, STATE, TICK, TOPIC_OF_NAME
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.verdict_so_far import properties_so_far
from passafe_services.tools.review.verdict_words import decide, in_words

from passafe_dashboard.columns import COMMAND_AGE, POWER_MARGIN, STATE_AGE, TANK, measured_h, psi
from passafe_dashboard.decimation import NS_PER_S, WorstSample
from passafe_dashboard.live.ages import ages
from passafe_dashboard.live.command_words import command_words
from passafe_dashboard.live.drive_state import NS_PER_MS, drive_json
from passafe_dashboard.live.drive_view import drive_view
from passafe_dashboard.live.feed import Feed, ReceivedEvent
from passafe_dashboard.live.session_words import silence_words
from passafe_dashboard.live.topic_monitor import TopicMonitor
from passafe_dashboard.palette import PHASE_MEANINGS, STATUS_STYLES

Json: TypeAlias = dict[str, Any]

SILENT_S: Final = 0.5
"""A filter or plant without a message for this long is silent."""

HEALTH_DEADLINE_S: Final = HEALTH.deadline_s or 3.0

REPORTING: Final = tuple(name for name in PROCESSES if name != "router")
"""Processes that publish Health; the router only forwards."""


def page_state(feed: Feed, now_ns: int) -> Json:
    """Return the whole state but the charts at ``now_ns`` (this process's monotonic clock, ns)."""
    live = liveness(feed, now_ns)
    return {
        "liveness": live,
        "server_ms": now_ns / NS_PER_MS,
        "ages": ages(feed, now_ns),
        "drive": drive_json(feed) | {"lease": None if feed.lease is None else _lease_json(feed.lease)},
        **drive_view(feed, live),
        "run": feed.run.number,
        "session": feed.session,
        "scenario": _scenario_json(feed),
        "filter": None if feed.run.tick is None else _filter_json(feed, feed.run.tick),
        "plant": None if feed.run.state is None else _plant_json(feed, feed.run.state),
        "worst": _worst_json(feed),
        "verdict": _verdict_json(feed),
        "status_counts": {status.name: count for status, count in feed.run.status_counts.items()},
        "mismatched_messages": feed.run.mismatched,
        "refused_messages": feed.refused,
        "processes": [_process_json(feed, name, now_ns) for name in REPORTING],
        "topics": [
            monitor.statistics(now_ns)._asdict() for _, monitor in sorted(feed.topic_monitors.items(), key=_table_order)
        ],
        "stop": stop_json(feed),
        "lease": None if feed.lease is None else _lease_json(feed.lease),
        "links": [
            {"link": link, "effect": effect, "count": count}
            for (link, effect), count in sorted(feed.run.link_effects.items())
        ],
        "link_states": [link_json(feed, name, now_ns) for name in LINKS],
        "events": [_event_json(event, now_ns) for event in feed.events],
    }


def _table_order(entry: tuple[tuple[str, str], TopicMonitor]) -> tuple[int, str]:
    """Return the sort key: order of the topic table, then name of the publisher."""
    (source, topic), _ = entry
    return tuple(TOPIC_OF_NAME).index(topic), source


def liveness(feed: Feed, now_ns: int) -> Json:
    """Return whether the state is current, ``ended``, ``waiting``, ``silent`` or ``live``, and a sentence for it."""
    if feed.end is not None:
        return {"state": "ended", "text": feed.end}
    ages = {
        source: feed.topic_monitors[key].age_s(now_ns) if (key := (source, topic.name)) in feed.topic_monitors else None
        for source, topic in (("filter", TICK), ("plant", STATE))
    }
    missing = [source for source, age_s in ages.items() if age_s is None]
    words = silence_words(feed.session)
    if missing:
        return {"state": "waiting", "text": words or f"No message from {' and '.join(missing)} yet."}
    silent = [f"{source} for {age_s:.1f} s" for source, age_s in ages.items() if age_s and age_s > SILENT_S]
    if silent:
        return {
            "state": "silent",
            "text": words or f"No message from {' and '.join(silent)}: the page shows the last state received.",
        }
    return {"state": "live", "text": "Messages are arriving."}


def _scenario_json(feed: Feed) -> Json | None:
    scenario = feed.scenario
    if scenario is None:
        return None
    return {
        "name": scenario.name,
        "title": scenario.title,
        "mode": scenario.filter.mode,
        "law": scenario.filter.law,
        "rate_hz": scenario.rate_hz,
        "duration_s": scenario.duration_s,
        "driver": None if feed.info is None else feed.info.driver,
    }


def _filter_json(feed: Feed, tick: FilterTick) -> Json:
    fits = len(tick.barriers) == len(feed.layout.barriers)
    return {
        "tick": tick.tick,
        "time_s": tick.effective_plant_ns / NS_PER_S,
        "status": tick.status.name,
        "meaning": STATUS_STYLES[tick.status].meaning,
        "mode": tick.mode,
        "law": tick.law,
        "barriers": [{"name": chain.name, "psi": chain.psi} for chain in tick.barriers] if fits else [],
        POWER_MARGIN: tick.power_margin,
        TANK: tick.tank_j,
        "slack_w": tick.slack,
        "u": tick.u,
        "u_nominal": tick.u_nominal,
        "u_h": tick.u_h,
        **_pushes_json(feed, tick),
        "override": _override_json(tick),
        "rows": [
            {"name": row.name, "active": row.active, "margin": row.margin, "dual": row.dual, "share": row.share}
            for row in tick.rows
        ],
        "certificate": as_dict(tick.certificate),
        STATE_AGE: _age_ms(tick.state_age_ns),
        COMMAND_AGE: _age_ms(tick.command_age_ns),
        "command_state": tick.command_state,
        "command_words": command_words(tick),
    }


def _override_json(tick: FilterTick) -> Json | None:
    """Return the part of the command that was held back, and what would have passed; ``None`` if not reported."""
    override = tick.override
    if not override.held_back:
        return None
    return as_dict(override) | {"held_back_norm": hypot(*override.held_back)}


def _age_ms(age_ns: int) -> float | None:
    return None if age_ns < 0 else age_ns * 1e-6


def _plant_json(feed: Feed, state: PlantState) -> Json:
    h = dict(zip(feed.layout.names, feed.measured_h(state) or (), strict=False))
    return {
        "time_s": state.plant_ns / NS_PER_S,
        "phase": state.phase.name,
        "meaning": PHASE_MEANINGS[state.phase],
        "x": state.x,
        **_drawn_json(feed, state),
        "y": state.y,
        "u": state.u,
        "h": [{"name": name, "value": value} for name, value in h.items()],
        "moved_m": feed.displacements_m(state),
        "applied_tick": state.applied_tick,
        "energy_in_j": state.energy_in_j,
        "energy_stored_j": state.energy_stored_j,
        "inputs_late": state.inputs_late,
        "inputs_refused": state.inputs_refused,
    }


def _drawn_json(feed: Feed, state: PlantState) -> Json:
    """Return a body in space, or places, angle and velocities of a robot that is not drawn where its state begins."""
    drawn = feed.layout.drawn
    if drawn is None or not feed.layout.fits(state):
        return {}
    x = state.x[: feed.layout.states]
    if feed.layout.body is not None:
        points, spheres = feed.layout.body.at(x)
        return {"body": {"points": points, "spheres": spheres}}
    places, heading, velocities = drawn.at(x)
    return {"places": places, "heading": heading, "velocities": velocities}


def _pushes_json(feed: Feed, tick: FilterTick) -> Json:
    """Return what was asked and decided as accelerations of the robot's points, where its input is something else."""
    drawn = feed.layout.drawn
    if drawn is None or drawn.pushes is None or len(tick.x_hat) != feed.layout.states:
        return {}
    allowed = [sent - nominal + asked for sent, nominal, asked in zip(tick.u, tick.u_nominal, tick.u_h, strict=False)]
    return {"pushes": {"asked": drawn.push(tick.x_hat, tick.u_h), "allowed": drawn.push(tick.x_hat, allowed)}}


def stop_json(feed: Feed) -> Json:
    """Return the emergency stop that is latched at the plant; an id as text, since JavaScript has no such integers."""
    state = feed.run.state
    if state is None or not state.stop:
        return {"id": None, "source": None}
    return {"id": str(state.stop), "source": state.stop_source}


def _lease_json(lease: OperatorLease) -> Json:
    return {
        "number": lease.number,
        "holder": str(lease.holder) if lease.holder else None,
        "device": lease.device,
        "heartbeat_ms": _age_ms(lease.command_age_ns),
        "refused": str(lease.refused) if lease.refused else None,
    }


def _worst_json(feed: Feed) -> Json:
    worst = feed.run.worst
    return {
        "barriers": [
            {
                "name": name,
                "measured": _worst(worst, measured_h(index)),
                "filter": _worst(worst, psi(index, 0)),
            }
            for index, name in enumerate(feed.layout.names)
        ],
        POWER_MARGIN: _worst(worst, POWER_MARGIN),
        TANK: _worst(worst, TANK),
    }


def _verdict_json(feed: Feed) -> Json | None:
    """Return the verdict on the run so far, by the rules and in the words of a review; ``None`` without a scenario."""
    if feed.scenario is None:
        return None
    worst = feed.run.worst
    h_min = [worst[column] for i in range(len(feed.layout.barriers)) if (column := measured_h(i)) in worst]
    properties = properties_so_far(
        feed.scenario,
        feed.run.fallbacks,
        feed.run.drive,
        h_min=min((Extremum(*lowest) for lowest in h_min), default=None),
        h_possible=feed.run.h_possible,
        power_margin_min=Extremum(*worst[POWER_MARGIN]) if POWER_MARGIN in worst else None,
        tank_min_j=Extremum(*worst[TANK]) if TANK in worst else None,
    )
    return {"outcome": decide(properties), "words": in_words(properties)}


def _worst(worst: Mapping[str, WorstSample], column: str) -> Json | None:
    found = worst.get(column)
    return None if found is None else found._asdict()


def link_json(feed: Feed, name: str, now_ns: int) -> Json:
    """Return one link at ``now_ns``: its settings in force and counts, null until its state was received."""
    topic, reader = LINKS[name]
    newest = feed.links.newest(name)
    about: Json = {"link": name, "topic": topic.name, "reader": reader, "age_s": None, "settings": None, "counts": None}
    if newest is None:
        return about
    state = as_dict(newest.state)
    return about | {
        "age_s": (now_ns - newest.received_ns) / NS_PER_S,
        "settings": state["parameters"]
        | {
            "outages": [(outage.start_s, outage.end_s) for outage in newest.state.parameters.outages],
            "trace_opportunities": newest.state.trace_opportunities,
        },
        "counts": {field: state[field] for field in (*LinkCounts._fields, "refused_corrupted", "refused_duplicate")},
    }


def _event_json(event: ReceivedEvent, now_ns: int) -> Json:
    fields = event._asdict()
    del fields["received_ns"]
    return fields | {"age_s": (now_ns - event.received_ns) / NS_PER_S}


def _process_json(feed: Feed, name: str, now_ns: int) -> Json:
    report = feed.processes.get(name)
    if report is None:
        return {"process": name, "state": "no report"}
    age_s = (now_ns - report.received_ns) / NS_PER_S
    state = "silent" if age_s > HEALTH_DEADLINE_S else "ok"
    return {"process": name, "state": state, "age_s": age_s} | as_dict(report.health)
