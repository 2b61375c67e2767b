"""Collect what a run's log says in words: events, changes of links, stretches in which something was wrong."""

from typing import NamedTuple

import numpy as np
from passafe_protocol.messages import Event, Header, LinkParameters, LinkState

from passafe_dashboard.run_record.plant_timeline import PlantTimeline

MOST_EVENTS = 400
REVIEW = "review"
"""Source of what was found in the log, and said by no process."""

SEVERITIES = ("error", "warning", "info")


class RunEvent(NamedTuple):
    """Something that happened, in words.

    Attributes:
        at_s: Plant time, s.
        severity: info, warning or error.
        source: Process that said so, or ``REVIEW``.
        text: In words.
    """

    at_s: float
    severity: str
    source: str
    text: str


class EventList:
    """Events of a run; of very many, the worst ones and the first."""

    def __init__(self) -> None:
        self.left_out = 0
        self._events: list[tuple[int, str, str, str]] = []

    def take_event(self, header: Header, event: Event) -> None:
        """Add an event that a process published."""
        severity = event.severity if event.severity in SEVERITIES else "info"
        self._append(header.wall_ns, severity, header.source, event.text)

    def take_link(self, header: Header, state: LinkState) -> None:
        """Add a link's settings when they were set, and a refusal of settings."""
        if state.refusal:
            self._append(header.wall_ns, "warning", header.source, f"link {state.link} refused: {state.refusal}")
        elif state.trigger not in ("period", "end"):
            settings = link_words(state.parameters)
            if settings or state.trigger != "start":
                self._append(header.wall_ns, "info", header.source, f"link {state.link}: {settings or 'unimpaired'}")

    def events(self, clock: PlantTimeline) -> list[RunEvent]:
        """Return the events in order of time."""
        if not self._events:
            return []
        at_s = clock.plant_s(np.array([event[0] for event in self._events], dtype=np.int64)).tolist()
        return sorted(RunEvent(t, *event[1:]) for t, event in zip(at_s, self._events, strict=True))

    def _append(self, wall_ns: int, severity: str, source: str, text: str) -> None:
        self._events.append((wall_ns, severity, source, text))
        if len(self._events) > MOST_EVENTS:
            mildest = max(range(len(self._events)), key=lambda i: (SEVERITIES.index(self._events[i][1]), i))
            del self._events[mildest]
            self.left_out += 1


def link_words(settings: LinkParameters) -> str:
    """Return the impairments of a link in words; empty without any."""
    words = []
    if settings.delay_s or settings.jitter_s:
        spread = f" ± {settings.jitter_s * 1e3:.3g} ms" if settings.jitter_s else ""
        words.append(f"delay {settings.delay_s * 1e3:.3g} ms{spread}")
    elif settings.quantiles_s:
        words.append("delay by histogram")
    for share, what in ((settings.loss, "loss"), (settings.duplicate, "copies"), (settings.corrupt, "bits flipped")):
        if share:
            words.append(f"{what} {share * 100:.3g} %")
    if settings.burst_enter:
        words.append("loss in bursts")
    if settings.rate_hz:
        words.append(f"at most {settings.rate_hz:.4g} messages/s")
    if settings.outages:
        words.append(f"{len(settings.outages)} outages")
    return ", ".join(words)
