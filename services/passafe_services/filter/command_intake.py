"""Intake of operator commands: lease, gate of the emergency stop and request, with their events and reports."""

from typing import Final

from msgspec.structs import replace
from passafe_protocol.messages import CommandState, Header, OperatorCommand, PlantState, Received
from passafe_protocol.topics import EVENT, LEASE

from passafe_services.filter.command_events import CommandEventEmitter
from passafe_services.filter.operator_lease import LeaseAnswer, OperatorLeases
from passafe_services.filter.operator_request import OperatorRequest, PassThroughRequest
from passafe_services.filter.stop_gate import StopGate
from passafe_services.node import Outgoing

_HOLDS: Final = LeaseAnswer.HOLDS


class CommandIntake:
    """Decides which commands reach the operator's request.

    Attributes:
        stop: Gate of the emergency stop.
    """

    def __init__(self, request: PassThroughRequest, events: CommandEventEmitter) -> None:
        """Start with nothing received.

        Args:
            request: Request of the operator, from its commands.
            events: Says when commands are too old to count.
        """
        self.stop = StopGate()
        self._request = request
        self._events = events
        self._leases = OperatorLeases()

    def restart(self) -> None:
        """Discard all commands and plant states."""
        self.stop.restart()
        self._request.restart()
        self._leases.restart()

    def observe(self, header: Header, state: PlantState) -> bool:
        """Learn from the newest plant state; return whether inputs sent before are void, see ``StopGate``."""
        is_void = self.stop.observe(header, state)
        if is_void:
            self._request.void()
        return is_void

    def receive(self, received: Received, command: OperatorCommand) -> None:
        """Receive a command: refuse it, or pass it on to the request.

        Args:
            received: The message.
            command: Its body.
        """
        admission = self._leases.admit(received, command)
        if admission is not _HOLDS:
            if admission is LeaseAnswer.REFUSED:
                return
            self._request.begin_session()
        if self.stop.opens(command):
            self._request.begin()
        self._request.receive(received, self.stop.pass_on(command))

    def at(self, now_ns: int) -> OperatorRequest:
        """Return the operator's request at a tick.

        Args:
            now_ns: Time at which the tick is due, monotonic, ns.
        """
        request = self._request.at(now_ns)
        if self.stop.is_open or request.is_stale:
            return request
        return replace(request, state=CommandState.STOPPED)

    def reports(self, now_ns: int) -> list[Outgoing]:
        """Return the lease and its events, if there is something to report.

        Args:
            now_ns: Time at which the step is due, monotonic, ns.
        """
        outgoing: list[Outgoing] = [(EVENT, event) for event in self._leases.pop_events()]
        lease = self._leases.report(now_ns)
        if lease is not None:
            outgoing.append((LEASE, lease))
        return outgoing

    def event(self, now_ns: int, request: OperatorRequest) -> list[Outgoing]:
        """Return an event if there is something new to say about the request at a tick."""
        event = self._events.event(now_ns, request)
        return [] if event is None else [(EVENT, event)]
