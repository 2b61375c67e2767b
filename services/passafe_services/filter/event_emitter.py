"""Emits events for changes of the filter's status and for notable overrides, each at most once a second."""

from typing import Final

import numpy as np
from passafe_protocol.messages import Event, FilterStatus

from passafe.decision import Decision, Status
from passafe.override import Explainer
from passafe_services.filter.override_text import OverrideText

EVENT_PERIOD_NS: Final = 1_000_000_000

CHECK_PERIOD_NS: Final = 100_000_000
"""Time until the next check after an override that was not notable; explaining one costs some 50 µs."""

REPEAT_AFTER_NS: Final = 2 * EVENT_PERIOD_NS
"""Time without a notable override after which the same causes are reported again."""

NOTABLE: Final = 0.1
"""‖held back‖ relative to ‖û‖ above which an override is reported."""

LEAST_NOTABLE: Final = 1e-3
"""The same limit relative to the largest input."""

_EVENTS: Final = {
    FilterStatus.STALE: ("warning", "the operator command or the plant state is stale"),
    FilterStatus.STOPPED: (
        "warning",
        "an emergency stop is latched at the plant: nothing is sent until it is cleared there",
    ),
    FilterStatus.UNCERTIFIED: (
        "error",
        "no solution passed the certificate: fail-safe law in force",
    ),
    FilterStatus.INFEASIBLE: (
        "error",
        "the hard rows are infeasible within the input limits: relaxed as little as possible",
    ),
    FilterStatus.AT_SAMPLES: (
        "error",
        "the hard rows can be kept at the sample, but no input is known to keep them for the whole period",
    ),
    FilterStatus.BACKUP: (
        "warning",
        "what is sent is judged by the backup law's course: it keeps every barrier, or keeps them longer",
    ),
}
_NORMAL: Final = ("info", "the filter's decisions are certified and its inputs fresh again")


class StatusEventEmitter:
    """Emits an event when the kind of the status changes.

    Attributes:
        settled: The last status that needed no event, and needs none again.
    """

    def __init__(self) -> None:
        self._reported = _NORMAL
        self.settled: FilterStatus | None = None
        self._quiet_until_ns = 0

    def event(self, now_ns: int, status: FilterStatus) -> Event | None:
        """Return an event if the kind of the status has changed since the last one, within the rate limit."""
        if status is self.settled:
            return None
        event = _EVENTS.get(status, _NORMAL)
        if event == self._reported:
            self.settled = status
            return None
        if now_ns < self._quiet_until_ns:
            return None
        self._reported = event
        self.settled = status
        self._quiet_until_ns = now_ns + EVENT_PERIOD_NS
        return Event(*event)


class OverrideEventEmitter:
    """Emits an event when an override becomes notable or its causes change.

    Attributes:
        check_due_ns: Time before which ``event`` returns ``None``, monotonic, ns.
    """

    def __init__(self, explainer: Explainer, override_text: OverrideText, largest_input: float) -> None:
        """Start with nothing reported.

        Args:
            explainer: Explainer of the filter.
            override_text: Override text of the filter.
            largest_input: Largest magnitude of an axis of u, units of u.
        """
        self._explainer, self._override_text = explainer, override_text
        self._least = LEAST_NOTABLE * largest_input
        self.check_due_ns = 0
        self._notable_ns = 0
        self._reported: tuple[Status, tuple[str, ...]] | None = None

    def event(self, now_ns: int, decision: Decision) -> Event | None:
        """Return an event if an override has become notable or has other causes, within the rate limit."""
        status = decision.status
        if now_ns < self.check_due_ns or not status.is_certified:  # under another law rows are no causes
            return None
        override = self._explainer.override(decision)
        relaxed = status in {Status.RELAXED, Status.INFEASIBLE}
        requested = float(np.linalg.norm(decision.u_nominal))
        if not relaxed and not override.size > max(NOTABLE * requested, self._least):
            self.check_due_ns = now_ns + CHECK_PERIOD_NS
            return None
        causes = (status if relaxed else Status.MODIFIED), self._override_text.causes(override)
        is_known = causes == self._reported and now_ns - self._notable_ns <= REPEAT_AFTER_NS
        self.check_due_ns, self._notable_ns, self._reported = now_ns + EVENT_PERIOD_NS, now_ns, causes
        if is_known:
            return None
        return Event("warning" if relaxed else "info", self._override_text.sentence(decision, override))
