"""Says in words when the filter's status changes in kind, at most once a second."""

from typing import Final

from protocol.messages import Event, FilterStatus

QUIET_NS: Final = 1_000_000_000

_WORDS: Final = {
    FilterStatus.STALE: ("warning", "the operator or the plant has not been heard of for too long"),
    FilterStatus.UNCERTIFIED: (
        "error",
        "no answer of the solver passed the certificate: fail-safe law in force",
    ),
    FilterStatus.INFEASIBLE: (
        "error",
        "the rows cannot all be kept within the input bound: fail-safe law in force",
    ),
}
_WELL: Final = ("info", "the filter's answers are certified and fresh again")


class StatusAnnouncer:
    """Remembers the kind of the last announced status."""

    def __init__(self) -> None:
        self._announced = _WELL
        self._settled: FilterStatus | None = None  # the last status that needed no event
        self._quiet_until_ns = 0

    def event(self, now_ns: int, status: FilterStatus) -> Event | None:
        """Return an event if the status differs in kind from the last announced one and it is not too soon."""
        if status is self._settled:
            return None
        words = _WORDS.get(status, _WELL)
        if words is self._announced:
            self._settled = status
            return None
        if now_ns < self._quiet_until_ns:
            return None
        self._announced = words
        self._settled = status
        self._quiet_until_ns = now_ns + QUIET_NS
        return Event(*words)
