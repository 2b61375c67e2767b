"""Operator node: sends the commands of its source."""

from collections.abc import Callable, Sequence
from typing import Final

from passafe_protocol.messages import (
    FilterTick,
    OperatorCommand,
    OperatorLease,
    PlantPhase,
    PlantState,
    Received,
    Steer,
)
from passafe_protocol.topics import COMMAND, EVENT, LEASE, STATE, STEER, STOP, TICK, Topic

from passafe_services.node import Outgoing
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.lease_view import LeaseView
from passafe_services.operator.page.page_driver import DEVICE, PageDriver
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import ButtonSource, CommandSource, ObservingSource, SourceClock
from passafe_services.operator.stop_button import StopButton

DISPLAY_PERIOD_NS: Final = 100_000_000
DISPLAY_STALE_NS: Final = 500_000_000
"""Age above which a message is no longer displayed."""

WAITING: Final = PlantPhase.WAITING
LOCAL: Final = SourceClock.LOCAL


class OperatorNode:
    """Sends one ``OperatorCommand`` per step, as long as no other operator holds the filter's lease.

    A script starts with the robot. Its time is ``plant_ns`` of the newest ``PlantState`` plus the local time since its
    arrival, and 0 while the plant is ``WAITING`` or unknown; so a script returns the same command at the same plant
    time with every driver. A person's device runs on local time.

    A second operator that joins reports in one ``Event`` that it waits, and sends nothing: until the lease is free, or
    it takes over. While an emergency stop is latched, commands are released; a ``ButtonSource`` can press it.

    With a ``PageDriver`` a page may take the place of the source (``STEER``), and hand it back.

    An ``ObservingSource`` receives every newer plant state before it is asked for the command of the step.

    A step depends on its arguments and on the inputs of the source only.

    Attributes:
        name: ``operator``.
        subscribes: Plant states and the filter's lease; with a display also filter ticks, with a page its commands.
    """

    name = COMMAND.publishers[0]

    def __init__(
        self,
        source: CommandSource,
        *,
        epoch: int,
        takes_over: bool = False,
        show: Callable[[OperatorView], None] | None = None,
        page: PageDriver | None = None,
    ) -> None:
        """Start with nothing received.

        Args:
            source: Source of the commands.
            epoch: Session epoch of this node's messages.
            takes_over: Whether to take the lease over from the operator that holds it.
            show: Called with the view for the display, at most every ``DISPLAY_PERIOD_NS``; must not block.
            page: Drives in the place of the source once a page says so; ``None``: no page can.
        """
        extra = ((TICK,) if show is not None else ()) + ((STEER,) if page is not None else ())
        self.subscribes: tuple[Topic, ...] = (STATE, LEASE, *extra)
        self._source = source
        self._observe = source.observe if isinstance(source, ObservingSource) else None
        self._buttons = source if isinstance(source, ButtonSource) else None
        self._pressed = (0, 0)
        self._page = page
        self._page_take_overs = 0
        self._lease = LeaseView(epoch, takes_over=takes_over)
        self._stop = StopButton(epoch)
        self._show = show
        self._state: PlantState | None = None
        self._state_ns = 0
        self._state_number = (-1, -1)
        self._echoed = (0, 0)
        self._tick: FilterTick | None = None
        self._tick_ns = 0
        self._first_ns: int | None = None
        self._show_due_ns = 0

    @property
    def finished(self) -> bool:
        """True when the operator has ended the session; the driver then stops."""
        return self._source.finished

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the command at ``now_ns``, or none while another session holds the lease; a due press comes first.

        Args:
            now_ns: Monotonic time of this step, ns; non-decreasing.
            inbox: Messages since the previous step, in order of arrival.
        """
        if inbox:
            self._read(inbox)
        command = self._stop.limit(self._command(now_ns), is_person=self._page_commands or self._source.clock is LOCAL)
        self._read_buttons()
        if self._show is not None and now_ns >= self._show_due_ns:
            self._show_due_ns = now_ns + DISPLAY_PERIOD_NS
            self._show(self._view(now_ns, command))
        outgoing: list[Outgoing] = []
        press, event = self._stop.due(now_ns), self._lease.event()
        if press is not None:
            outgoing.append((STOP, press))
        if event is not None:
            outgoing.append((EVENT, event))
        if self._lease.sends:
            outgoing.append((COMMAND, self._message(now_ns, command)))
        return outgoing

    def _message(self, now_ns: int, command: Command) -> OperatorCommand:
        waited_ns = 0 if self._state is None else max(now_ns - self._state_ns, 0)
        echo = (*self._echoed, waited_ns)
        return OperatorCommand(
            command.u_h,
            command.u_h_rate,
            command.enabled,
            DEVICE if self._page_commands else self._source.device,
            *echo,
            self._lease.requested,
        )

    @property
    def _page_commands(self) -> bool:
        return self._page is not None and self._page.commands

    def _command(self, now_ns: int) -> Command:
        if self._page is not None and self._page.commands:
            return self._page.command(now_ns)
        return self._source.command(self._source_time_s(now_ns))

    def _read_buttons(self) -> None:
        if self._page is not None and self._page.take_overs > self._page_take_overs:
            self._page_take_overs = self._page.take_overs
            self._lease.take_over()
        if self._buttons is None:
            return
        stops, take_overs = self._pressed
        self._pressed = (self._buttons.stops, self._buttons.take_overs)
        if self._buttons.stops > stops:
            self._stop.press()
        if self._buttons.take_overs > take_overs:
            self._lease.take_over()

    def _read(self, inbox: Sequence[Received]) -> None:
        known = self._state
        for received in inbox:
            body = received.body
            if isinstance(body, PlantState):
                number = (received.term, received.header.sequence)
                if number > self._state_number:  # reordered states are ignored
                    self._state_number = number
                    self._state, self._state_ns = body, received.received_ns
                    self._echoed = (received.header.epoch, received.header.scheduled_ns)
                    self._stop.observe(body)
            elif isinstance(body, OperatorLease):
                self._lease.receive(body)
            elif isinstance(body, FilterTick):
                self._tick, self._tick_ns = body, received.received_ns
            elif isinstance(body, Steer) and self._page is not None:
                self._page.receive(received, body)
        if self._observe is not None and self._state is not known and self._state is not None:
            self._observe(self._state)

    def _source_time_s(self, now_ns: int) -> float:
        if self._source.clock is LOCAL:
            if self._first_ns is None:
                self._first_ns = now_ns
            return (now_ns - self._first_ns) / 1e9
        state = self._state
        if state is None or state.phase is WAITING:
            return 0.0
        time_ns = state.plant_ns + now_ns - self._state_ns
        return time_ns / 1e9 if time_ns > 0 else 0.0

    def _view(self, now_ns: int, command: Command) -> OperatorView:
        state = self._state if now_ns - self._state_ns <= DISPLAY_STALE_NS else None
        tick = self._tick if now_ns - self._tick_ns <= DISPLAY_STALE_NS else None
        levels = [] if tick is None else [(chain.psi[0], chain.name) for chain in tick.barriers if chain.psi]
        h, name = min(levels, default=(0.0, ""))
        return OperatorView(
            u_h=command.u_h,
            enabled=command.enabled,
            holder=self._lease.holder,
            stop_source=self._stop.source,
            position=None if state is None else state.x[: len(command.u_h)],
            status=None if tick is None else tick.status,
            nearest=(name, h) if levels else None,
        )
