"""The operator process as a node: asks its source and sends what it says."""

from collections.abc import Callable, Sequence
from typing import Final

from passafe_protocol.messages import Event, FilterTick, OperatorCommand, PlantPhase, PlantState, Received
from passafe_protocol.topics import COMMAND, EVENT, STATE, TICK, Topic

from passafe_services.node import Outgoing
from passafe_services.operator.keyboard.display import OperatorView
from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.source import Seeing, Source, SourceClock

SHOW_PERIOD_NS: Final = 100_000_000
KNOWN_NS: Final = 500_000_000
"""What came longer ago is not shown as if it were so now."""

WAITING: Final = PlantPhase.WAITING
LOCAL: Final = SourceClock.LOCAL


class OperatorNode:
    """Sends one ``OperatorCommand`` a step.

    A script begins when the robot does. Its time is ``plant_ns`` of the newest ``PlantState`` plus the local
    time since that arrived, and 0 while the plant is ``WAITING`` or has not been heard of; so every driver
    asks a script for the same thing at the same plant time. A person's device runs on local time.

    Two operators: the session with the larger epoch, the one started later, drives. A node that sees a
    command of a larger epoch than its own says so in one ``Event`` and never sends again; going on would be
    in vain, as a filter refuses the smaller epoch for good once it has seen the larger.

    A source that is ``Seeing`` is shown the newest state, in every step in which a newer one came, before it is asked.

    A step depends on its arguments and on what the source was handed, nothing else.

    Attributes:
        name: ``operator``.
        subscribes: Plant state and operators' commands; filter ticks too if somebody looks at the display.
    """

    name = COMMAND.publishers[0]

    def __init__(self, source: Source, *, epoch: int, show: Callable[[OperatorView], None] | None = None) -> None:
        """Start with nothing heard.

        Args:
            source: Who or what drives.
            epoch: Session epoch that the driver stamps on what this node sends.
            show: Takes what the operator is to see, at most every ``SHOW_PERIOD_NS``; must not wait.
        """
        self.subscribes: tuple[Topic, ...] = (STATE, COMMAND) if show is None else (STATE, COMMAND, TICK)
        self._source = source
        self._see = source.see if isinstance(source, Seeing) else None
        self._epoch = epoch
        self._show = show
        self._state: PlantState | None = None
        self._state_ns = 0
        self._state_number = (-1, -1)
        self._tick: FilterTick | None = None
        self._tick_ns = 0
        self._newer_epoch: int | None = None
        self._announced = False
        self._first_ns: int | None = None
        self._show_due_ns = 0

    @property
    def finished(self) -> bool:
        """Whether the operator asked to end the session: the driver then stops."""
        return self._source.finished

    @property
    def superseded(self) -> bool:
        """Whether a newer operator session took over and this one is silent."""
        return self._newer_epoch is not None

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Return the command at ``now_ns``, or nothing once a newer session drives.

        Args:
            now_ns: Monotonic time of this step, ns; never smaller than in the step before.
            inbox: Messages since the step before, in order of arrival.
        """
        if inbox:
            self._read(inbox)
        command = self._source.command(self._source_time_s(now_ns))
        if self._show is not None and now_ns >= self._show_due_ns:
            self._show_due_ns = now_ns + SHOW_PERIOD_NS
            self._show(self._view(now_ns, command))
        if self._newer_epoch is None:
            body = OperatorCommand(command.u_h, command.u_h_rate, command.enabled, self._source.device)
            return ((COMMAND, body),)
        return self._announcement(self._newer_epoch)

    def _read(self, inbox: Sequence[Received]) -> None:
        known = self._state
        for received in inbox:
            body = received.body
            if isinstance(body, PlantState):
                number = (received.header.epoch, received.header.sequence)
                if number > self._state_number:  # not one that a newer one overtook
                    self._state_number = number
                    self._state, self._state_ns = body, received.received_ns
            elif isinstance(body, OperatorCommand):
                if received.header.epoch > self._epoch:
                    self._newer_epoch = received.header.epoch
            elif isinstance(body, FilterTick):
                self._tick, self._tick_ns = body, received.received_ns
        if self._see is not None and self._state is not known and self._state is not None:
            self._see(self._state)

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

    def _announcement(self, newer_epoch: int) -> Sequence[Outgoing]:
        if self._announced:
            return ()
        self._announced = True
        text = f"operator session {newer_epoch} is newer than {self._epoch}: this one is silent from now on"
        return ((EVENT, Event("warning", text)),)

    def _view(self, now_ns: int, command: Command) -> OperatorView:
        state = self._state if now_ns - self._state_ns <= KNOWN_NS else None
        tick = self._tick if now_ns - self._tick_ns <= KNOWN_NS else None
        levels = [] if tick is None else [(chain.psi[0], chain.name) for chain in tick.barriers if chain.psi]
        h, name = min(levels, default=(0.0, ""))
        return OperatorView(
            u_h=command.u_h,
            enabled=command.enabled,
            superseded=self.superseded,
            position=None if state is None else state.x[: len(command.u_h)],
            status=None if tick is None else tick.status,
            nearest=(name, h) if levels else None,
        )
