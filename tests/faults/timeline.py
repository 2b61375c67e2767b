"""Times and words of one fault, from the log of the run in which it happened."""

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from passafe_protocol.messages import CommandState, Event, FilterTick, PlantPhase, PlantState
from passafe_services.tools.review.run_log import RunLog

GRID_NS: Final = 5_000_000
"""Resolution of all times."""

FRESH_NS: Final = 60_000_000
"""Age of the newest tick or state above which nobody knows that the robot is driven: 15 periods at 250 Hz."""

LASTING: Final = 60
"""Points of the grid for which the robot has to be driven without a break until that counts as recovered: 0.3 s."""

STUMBLE_S: Final = 0.2
"""Time for which a robot that drives on may go without inputs, s: its processes share two processors with others."""

COUNTS: Final = frozenset({CommandState.COUNTS, CommandState.RESUMES})

Samples = Sequence[tuple[int, bool]]


@dataclass(frozen=True, kw_only=True, slots=True)
class Effect:
    """Effect of a fault on the robot.

    Attributes:
        to_safe_s: From the fault until no input of the filter or no command counts any more; ``None``: it drove on.
        to_recover_s: From the end of the fault until it is driven again for good; ``None``: never.
        undriven_s: Time without being driven, in all.
        story: What the log says of it.
    """

    to_safe_s: float | None
    to_recover_s: float | None
    undriven_s: float
    story: tuple[str, ...]


class Timeline:
    """Record of when a robot was driven; times are monotonic, ns.

    Args:
        states: When states were sent, and whether an input of the filter was in force; in order.
        ticks: When ticks were sent, and whether the operator's command counted; in order.
        events: When events were sent, their source, severity and text; in order.
    """

    def __init__(self, states: Samples, ticks: Samples, events: Sequence[tuple[int, str, str, str]]) -> None:
        self._samples = tuple(([at for at, _ in each], [so for _, so in each]) for each in (states, ticks))
        self._events = events

    @classmethod
    def of(cls, log: RunLog) -> "Timeline":
        """Return the timeline of a log, of the sessions that came first where two overlap."""
        return cls(
            sorted((s.header.sent_ns, s.body.phase is PlantPhase.RUNNING) for s in log.of(PlantState)),
            sorted((t.header.sent_ns, t.body.command_state in COUNTS) for t in log.of(FilterTick)),
            sorted((e.header.sent_ns, e.header.source, e.body.severity, e.body.text) for e in log.of(Event)),
        )

    @property
    def end_ns(self) -> int:
        """Time of the last state."""
        times = self._samples[0][0]
        return times[-1] if times else 0

    def is_driven(self, at_ns: int) -> bool:
        """Return whether the robot was driven at a time, as far as anybody could know."""
        for times, values in self._samples:
            index = bisect_right(times, at_ns) - 1
            if index < 0 or at_ns - times[index] > FRESH_NS or not values[index]:
                return False
        return True

    def effect(self, began_ns: int, ended_ns: int, until_ns: int) -> Effect:
        """Return the effect of a fault.

        Args:
            began_ns: When it began.
            ended_ns: When it ended.
            until_ns: When the next one began.
        """
        grid = range(began_ns, until_ns, GRID_NS)
        driven = [self.is_driven(at) for at in grid]
        undriven_s = driven.count(False) * GRID_NS * 1e-9
        driven = without_stumbles(driven, round(STUMBLE_S * 1e9) // GRID_NS)
        lost = next((k for k, so in enumerate(driven) if not so), None)
        story = self._story(began_ns, until_ns)
        if lost is None or undriven_s <= STUMBLE_S:
            return Effect(to_safe_s=None, to_recover_s=0.0, undriven_s=undriven_s, story=story)
        begin = max(lost, bisect_left(grid, ended_ns))
        again = next((k for k in range(begin, len(driven)) if all(driven[k : k + LASTING])), None)
        complete = again is not None and again + LASTING <= len(driven)
        return Effect(
            to_safe_s=lost * GRID_NS * 1e-9,
            to_recover_s=max(0, grid[again] - ended_ns) * 1e-9 if complete and again is not None else None,
            undriven_s=undriven_s,
            story=story,
        )

    def _story(self, began_ns: int, until_ns: int) -> tuple[str, ...]:
        """Return what the log says in that time: warnings and errors first, each once."""
        found = [event for event in self._events if began_ns <= event[0] < until_ns]
        texts = [f"{source}: {text}" for _, source, severity, text in found if severity != "info"]
        texts += [f"{source}: {text}" for _, source, severity, text in found if severity == "info"]
        return tuple(dict.fromkeys(text for text in texts if "held back" not in text))


def without_stumbles(driven: Sequence[bool], most: int) -> list[bool]:
    """Return the same with every gap of up to ``most`` points counted as driven, but for those at either end."""
    found: list[bool] = []
    for so, run in groupby(driven):
        length = len(list(run))
        is_inside = bool(found) and len(found) + length < len(driven)
        found += [so or (is_inside and length <= most)] * length
    return found
