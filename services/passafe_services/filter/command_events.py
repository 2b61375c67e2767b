"""Events that say that commands come too late to count, and that they count again."""

from typing import Final

from passafe_protocol.messages import CommandState, Event

from passafe_services.filter.operator_request import OperatorRequest

EVENT_PERIOD_NS: Final = 1_000_000_000

_REPORTED: Final = frozenset({CommandState.DELAYED, CommandState.RESUMES})


class CommandEventEmitter:
    """Emits an event when commands become too old on the way, or ramp in again; at most one a second."""

    def __init__(self, stale_ns: int, resume_ns: int) -> None:
        """Start with nothing reported.

        Args:
            stale_ns: Age above which a command does not count, ns.
            resume_ns: Time of the ramp, ns.
        """
        self._stale_ns = stale_ns
        self._resume_ns = resume_ns
        self._reported: CommandState | None = None
        self._quiet_until_ns = 0

    def event(self, now_ns: int, request: OperatorRequest) -> Event | None:
        """Return an event if there is something new to say about the request at a tick, within the rate limit."""
        state = request.state
        if state is self._reported:
            return None
        if state not in _REPORTED:
            self._reported = state
            return None
        if now_ns < self._quiet_until_ns:
            return None
        self._reported, self._quiet_until_ns = state, now_ns + EVENT_PERIOD_NS
        if state is CommandState.RESUMES:
            return Event("info", f"commands count again: they ramp in within {self._resume_ns / 1e9:g} s")
        age_ms, stale_ms = request.age_ns / 1e6, self._stale_ns / 1e6
        text = f"commands are {age_ms:.0f} ms old when they arrive, allowed {stale_ms:.0f} ms: they do not count"
        return Event("warning", text)
