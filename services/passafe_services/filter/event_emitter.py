"""Says in words when the filter's status changes in kind, and what it overrides and why, each at most once a second."""

from typing import Final

import numpy as np
from passafe_protocol.messages import Event, FilterStatus

from passafe.decision import Decision, Status
from passafe.override import Explainer
from passafe_services.filter.override_text import OverrideText

QUIET_NS: Final = 1_000_000_000

LOOK_AGAIN_NS: Final = 100_000_000
"""How long an override that is not notable is not looked at again; explaining costs some 50 µs."""

FORGET_NS: Final = 2 * QUIET_NS
"""How long nothing notable must happen for the same reasons to be told again."""

NOTABLE: Final = 0.1
"""‖held back‖ relative to ‖û‖ from which an override is told."""

LEAST_NOTABLE: Final = 1e-3
"""The same relative to the largest input."""

_WORDS: Final = {
    FilterStatus.STALE: ("warning", "the operator or the plant has not been heard of for too long"),
    FilterStatus.UNCERTIFIED: (
        "error",
        "no answer of the solver passed the certificate: fail-safe law in force",
    ),
    FilterStatus.INFEASIBLE: (
        "error",
        "the hard rows cannot all be kept within the limits: they are missed by as little as possible",
    ),
}
_WELL: Final = ("info", "the filter's answers are certified and fresh again")


class StatusEventEmitter:
    """Remembers the kind of the last announced status.

    Attributes:
        settled: The last status that needed no event, and needs none again.
    """

    def __init__(self) -> None:
        self._announced = _WELL
        self.settled: FilterStatus | None = None  # the last status that needed no event
        self._quiet_until_ns = 0

    def event(self, now_ns: int, status: FilterStatus) -> Event | None:
        """Return an event if the status differs in kind from the last announced one and it is not too soon."""
        if status is self.settled:
            return None
        words = _WORDS.get(status, _WELL)
        if words == self._announced:
            self.settled = status
            return None
        if now_ns < self._quiet_until_ns:
            return None
        self._announced = words
        self.settled = status
        self._quiet_until_ns = now_ns + QUIET_NS
        return Event(*words)


class OverrideEventEmitter:
    """Remembers which reasons it announced last, and when it may look again.

    Attributes:
        look_ns: Before that ``event`` has nothing to say, monotonic, ns.
    """

    def __init__(self, explainer: Explainer, wording: OverrideText, largest_input: float) -> None:
        """Start with nothing announced.

        Args:
            explainer: Of the filter.
            wording: Of the filter.
            largest_input: Largest magnitude of an axis of u, units of u.
        """
        self._explainer, self._wording = explainer, wording
        self._least = LEAST_NOTABLE * largest_input
        self.look_ns = 0
        self._notable_ns = 0
        self._announced: tuple[Status, tuple[str, ...]] | None = None

    def event(self, now_ns: int, decision: Decision) -> Event | None:
        """Return an event if an override has become notable, or is for other reasons, and it is not too soon."""
        status = decision.status
        if now_ns < self.look_ns or status is Status.UNCERTIFIED:  # the fail-safe law has no reasons but its own
            return None
        override = self._explainer.override(decision)
        gave_up = status in {Status.RELAXED, Status.INFEASIBLE}
        asked = float(np.linalg.norm(decision.u_nominal))
        if not gave_up and not override.size > max(NOTABLE * asked, self._least):
            self.look_ns = now_ns + LOOK_AGAIN_NS
            return None
        reasons = (status if gave_up else Status.MODIFIED), self._wording.reasons(override)
        is_known = reasons == self._announced and now_ns - self._notable_ns <= FORGET_NS
        self.look_ns, self._notable_ns, self._announced = now_ns + QUIET_NS, now_ns, reasons
        return None if is_known else Event("warning" if gave_up else "info", self._wording.sentence(decision, override))
