"""Kills processes of a running demo, or cuts its network, at random moments."""

import os
import random
import signal
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from live_demo import PATIENCE_S, LiveDemo, is_running
from passafe_protocol.messages import PlantState
from passafe_protocol.topics import COMMAND, STATE, TICK
from passafe_services.loop.process_spec import RestartPolicy
from passafe_services.tools.review.sequence_breaks import SequenceBreak

KINDS = ("filter", "router", "operator", "outage")
QUIET_S = (0.3, 3.0)
OUTAGE_S = (0.05, 1.0)
SETTLED_S = 0.2
"""Time after the end of an outage from which a state counts as one of after it."""


@dataclass(frozen=True, kw_only=True)
class Strike:
    """One kill or outage.

    Attributes:
        number: Counted from 1.
        demo: Number of the demo it happened in, from 1.
        kind: What was killed, or ``outage``.
        outage_s: How long the router stood still.
        wall_ns: Wall time of it, Unix, ns.
        resumed: Whether the plant applied inputs again, made after that, within ``PATIENCE_S``.
        at_s: Plant time of the first missing input after that, s; ``None``: the input sequence never broke.
        missed_after_s: From then until an input was missing.
        fail_safe_after_s: From then until the fail-safe law was in force.
        resumed_after_s: From then until an input was applied again.
    """

    number: int
    demo: int
    kind: str
    outage_s: float
    wall_ns: int
    resumed: bool
    at_s: float | None = None
    missed_after_s: float | None = None
    fail_safe_after_s: float | None = None
    resumed_after_s: float | None = None

    def with_break(self, first: SequenceBreak) -> "Strike":
        """Return this strike with the times of the sequence break that followed it."""
        return replace(
            self,
            at_s=first.at_s,
            missed_after_s=self._since_s(first.wall_ns),
            fail_safe_after_s=self._since_s(first.fail_safe_wall_ns),
            resumed_after_s=self._since_s(first.resumed_wall_ns),
        )

    def _since_s(self, wall_ns: int | None) -> float | None:
        return None if wall_ns is None else (wall_ns - self.wall_ns) * 1e-9


def strike_at_random(
    demo: LiveDemo, chance: random.Random, numbers: range, demo_number: int, report: Callable[[str], object]
) -> list[Strike]:
    """Strike once for each number; stop early where the plant does not apply inputs again."""
    strikes: list[Strike] = []
    for number in numbers:
        time.sleep(chance.uniform(*QUIET_S))
        recent = [each.kind for each in strikes if time.time_ns() - each.wall_ns < RestartPolicy().within_s * 1e9]
        kind = chance.choice([kind for kind in KINDS if kind == "outage" or recent.count(kind) < RestartPolicy().most])
        outage_s = chance.uniform(*OUTAGE_S) if kind == "outage" else 0.0
        wall_ns, resumed = cut(demo, outage_s) if kind == "outage" else kill(demo, kind)
        strikes.append(
            Strike(number=number, demo=demo_number, kind=kind, outage_s=outage_s, wall_ns=wall_ns, resumed=resumed)
        )
        report(f"{number}: {kind}, {'resumed' if resumed else f'not resumed within {PATIENCE_S:g} s'}")
        if not resumed:
            break
    time.sleep(1.0)
    return strikes


def cut(demo: LiveDemo, outage_s: float) -> tuple[int, bool]:
    """Stop the router for a while; return when, and whether the plant applied inputs again after that."""
    pid, wall_ns = demo.pid("router"), time.time_ns()
    os.kill(pid, signal.SIGSTOP)
    time.sleep(outage_s)
    os.kill(pid, signal.SIGCONT)
    since_ns = time.time_ns() + round(SETTLED_S * 1e9)
    return wall_ns, demo.receives(STATE, lambda head, body: head.wall_ns > since_ns and is_running(body))


def kill(demo: LiveDemo, name: str) -> tuple[int, bool]:
    """Kill a process; return when, and whether the plant applied inputs again that were made after that."""
    filter_epoch, operator_epoch = demo.newest_epoch(TICK), demo.newest_epoch(COMMAND)
    router, pid, wall_ns = demo.bus.router, demo.pid(name), time.time_ns()
    os.kill(pid, signal.SIGKILL)
    if name == "filter":
        return wall_ns, demo.receives(
            STATE,
            lambda _, body: isinstance(body, PlantState) and body.input_epoch > filter_epoch and is_running(body),
        )
    if name == "router":
        return wall_ns, demo.receives(
            STATE,
            lambda head, body: (
                demo.bus.router not in {"", router} and head.wall_ns > wall_ns + 50_000_000 and is_running(body)
            ),
        )
    is_back = demo.receives(COMMAND, lambda header, _: header.epoch > operator_epoch)
    since_ns = time.time_ns()
    return wall_ns, is_back and demo.receives(STATE, lambda head, body: head.wall_ns > since_ns and is_running(body))


def with_breaks(strikes: Sequence[Strike], breaks: Sequence[SequenceBreak]) -> list[Strike]:
    """Return the strikes, each with the first sequence break between it and the next one."""
    ends_ns = [strike.wall_ns for strike in strikes[1:]] + [sys.maxsize]
    found = []
    for strike, end_ns in zip(strikes, ends_ns, strict=True):
        first = next((each for each in breaks if strike.wall_ns <= each.wall_ns < end_ns), None)
        found.append(strike if first is None else strike.with_break(first))
    return found
