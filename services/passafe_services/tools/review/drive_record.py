"""Record of whether the robot could be driven: by certified inputs of the filter, from commands that were fresh."""

from collections.abc import Iterable
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray
from passafe_protocol.messages import FilterStatus

from passafe_services.tools.review.filter_claims import IntArray
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.trajectory import NS_PER_S

LONGEST_END_S: Final = 1.0
"""Plant time for which a run may end without an input of the filter or a fresh command: the end is never sharp."""

NOTABLE_SHARE: Final = 0.25
"""Share of a run without an input or a command above which a verdict mentions it."""


_FALLBACKS: Final = tuple(status.value for status in FilterStatus if status.is_fallback)


class _LastSeen:
    """Record of when something was last so, and the newest time at which it was looked at, plant time, ns."""

    def __init__(self) -> None:
        self.seen_ns = self.newest_ns = 0
        self.first_ns: int | None = None
        self.is_set = False
        self.ended_wall_ns = 0
        self.state_sent_ns = self.health_sent_ns = 0

    def add(self, at_ns: int, *, so: bool) -> None:
        """Add a sample; one before the newest begins anew, as a restarted plant does."""
        if self.first_ns is None:
            self.first_ns = at_ns
        if so or at_ns < self.newest_ns:
            self.seen_ns, self.is_set = at_ns, True
        self.newest_ns = at_ns

    def add_all(self, at_ns: IntArray, so: NDArray[np.bool_]) -> None:
        """Add samples in order, at least one."""
        before = np.concatenate(([self.newest_ns], at_ns[:-1]))
        (begins,) = np.nonzero(so | (at_ns < before))
        if self.first_ns is None:
            self.first_ns = int(at_ns[0])
        if begins.size:
            self.seen_ns, self.is_set = int(at_ns[begins[-1]]), True
        self.newest_ns = int(at_ns[-1])

    def follow(self, other: "_LastSeen") -> None:
        """Add the samples of another record after those of this one."""
        if other.first_ns is None:
            return
        if other.is_set:
            self.seen_ns, self.is_set = other.seen_ns, True
        elif other.first_ns < self.newest_ns:
            self.seen_ns, self.is_set = other.first_ns, True
        self.newest_ns = other.newest_ns

    @property
    def silent_s(self) -> float:
        """Time for which a session of the plant went on after its last state, s: it had none of the robot."""
        return max(0, self.health_sent_ns - self.state_sent_ns) / NS_PER_S if self.state_sent_ns else 0.0

    @property
    def since_s(self) -> float:
        """Plant time from when it was last so to the newest sample, s."""
        return (self.newest_ns - self.seen_ns) / NS_PER_S


class DriveRecord:
    """Record of what moved the robot, from ticks and states as they come."""

    def __init__(self) -> None:
        self._ticks = self._states = 0
        self._is_answered = False
        self._without = self._uncommanded = 0
        self._at_end = 0  # newest ticks without a command that take effect when the newest does
        self._commanded = _LastSeen()
        self._driven_of: dict[int, _LastSeen] = {}

    @classmethod
    def of(cls, ticks: Iterable[tuple[FilterStatus, int]], states: Iterable[tuple[bool, int]]) -> Self:
        """Return the record of a run.

        Args:
            ticks: Status and plant time, ns, of each, in order.
            states: Whether an input of the filter was in force, and plant time, ns, of each, in order.
        """
        record = cls()
        for status, at_ns in ticks:
            record.add_tick(status, at_ns)
        for runs, at_ns in states:
            record.add_state(at_ns, runs=runs)
        return record

    def add_tick(self, status: FilterStatus, at_ns: int) -> None:
        """Add a tick that takes effect at a plant time, ns."""
        self._ticks += 1
        self._is_answered = self._is_answered or not status.is_fallback
        is_commanded = status is not FilterStatus.STALE
        self._uncommanded += not is_commanded
        self._at_end = 0 if is_commanded or at_ns != self._commanded.newest_ns else self._at_end + 1
        self._commanded.add(at_ns, so=is_commanded)

    def add_ticks(self, status: IntArray, at_ns: IntArray) -> None:
        """Add ticks in order, by numbers of their status and the plant times, ns, at which they take effect."""
        if not at_ns.size:
            return
        self._ticks += at_ns.size
        self._is_answered = self._is_answered or not bool(np.isin(status, _FALLBACKS).all())
        is_commanded = status != FilterStatus.STALE.value
        self._uncommanded += int((~is_commanded).sum())
        repeats = ~is_commanded & (at_ns == np.concatenate(([self._commanded.newest_ns], at_ns[:-1])))
        tail = int(np.argmin(repeats[::-1])) if not repeats.all() else at_ns.size
        self._at_end = tail + (self._at_end if tail == at_ns.size else 0)
        self._commanded.add_all(at_ns, is_commanded)

    def add_state(self, at_ns: int, *, runs: bool) -> None:
        """Add a state of the plant with its first input behind it, and whether an input of the filter is in force."""
        self._states += 1
        self._without += not runs
        self._driven_of.setdefault(0, _LastSeen()).add(at_ns, so=runs)

    def add_states(
        self, at_ns: IntArray, runs: NDArray[np.bool_], *, session: int, wall_ns: int, sent_ns: int = 0
    ) -> None:
        """Add states of a session of the plant in order.

        Args:
            at_ns: Plant times, ns, shape (N,).
            runs: Whether an input of the filter is in force, shape (N,).
            session: Number of the session.
            wall_ns: Wall time of the session's newest state, ns: the session that ends last shows how the run ended.
            sent_ns: When that state was sent, by the plant's clock, ns; 0 if it is not known.
        """
        driven = self._driven_of.setdefault(session, _LastSeen())
        driven.ended_wall_ns, driven.state_sent_ns = wall_ns, sent_ns
        if at_ns.size:
            self._states += at_ns.size
            self._without += int((~runs).sum())
            driven.add_all(at_ns, runs)

    def add_health(self, sent_ns: int, *, session: int) -> None:
        """Add that a session of the plant was there when it reported its health, by its own clock, ns."""
        self._driven_of.setdefault(session, _LastSeen()).health_sent_ns = sent_ns

    @property
    def _silent_s(self) -> float:
        """Time for which the plant that ended last went on without a state of the robot, s."""
        return max(self._driven_of.values(), key=lambda each: each.ended_wall_ns, default=_LastSeen()).silent_s

    @property
    def _driven(self) -> _LastSeen:
        """Record over all sessions, in the order in which they ended."""
        whole = _LastSeen()
        for of_session in sorted(self._driven_of.values(), key=lambda driven: driven.ended_wall_ns):
            whole.follow(of_session)
        return whole

    def property(self) -> Property:
        """Return the property that the robot could be driven, to the end of the run."""
        worst_s = max(self._driven.since_s, self._silent_s, self._commanded.since_s)
        is_known = bool(self._states and self._ticks)
        note = self._against()
        return Property(
            holds=not note if is_known else None,
            required=True,
            worst=worst_s if is_known and self._is_answered else None,
            at_s=None,
            requirement=(
                "at some time an answer outside of every fallback, and at the end no stretch without an input of the "
                f"filter, a state of the robot or a fresh command, s, > {LONGEST_END_S:g}"
            ),
            allowed=f"≤ {LONGEST_END_S:g}",
            note=note or self._share(),
        )

    def _share(self) -> str:
        """Return in words of how much of the run the verdict speaks, if that is notably less than all of it.

        The last ticks without a command that take effect at one plant time are left out: a filter outlives its plant.
        """
        uncommanded, ticks = self._uncommanded - self._at_end, self._ticks - self._at_end
        without, stale = (
            count / total if total else 0.0 for count, total in ((self._without, self._states), (uncommanded, ticks))
        )
        parts = []
        if without > NOTABLE_SHARE:
            parts.append(f"without an input of the filter for {_percent(without)} of the run")
        if stale > NOTABLE_SHARE:
            parts.append(f"without a fresh command for {_percent(stale)} of the ticks")
        return f"the robot was {' and '.join(parts)}" if parts else ""

    def _against(self) -> str:
        if not self._states:
            return "the robot never had an input of the filter"
        found = []
        if self._ticks and not self._is_answered:
            found.append("the filter never left a fallback")
        if self._driven.since_s > LONGEST_END_S:
            found.append(f"the robot stood without an input of the filter for the last {self._driven.since_s:.3g} s")
        if self._silent_s > LONGEST_END_S:
            found.append(f"the plant had no state of the robot for the last {self._silent_s:.3g} s")
        if self._commanded.since_s > LONGEST_END_S:
            found.append(f"no fresh command came in the last {self._commanded.since_s:.3g} s")
        return ", ".join(found)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share < 1.0 else "all"
