"""Gate for commands after an emergency stop at the plant: those made knowing of its clear count again."""

from msgspec.structs import replace
from passafe_protocol.messages import Header, OperatorCommand, PlantState


class StopGate:
    """Gate for commands, closed by an emergency stop.

    While a stop is latched a command counts as released. After the clear it counts if it was made knowing of it: it
    echoes a plant state at or after the first one that shows the clear. A sender that echoes nothing has to release the
    dead-man switch once. So no command that was made before the clear counts, whatever the network did to it.

    Attributes:
        is_stopped: Whether the newest plant state shows a latched stop.
        cleared: ``stops_cleared`` of the newest plant state.
    """

    def __init__(self) -> None:
        """Start open."""
        self.restart()

    def restart(self) -> None:
        """Discard what is known: no plant state was received."""
        self.is_stopped = False
        self.cleared = 0
        self._plant_epoch = 0
        self._cleared_ns: int | None = None  # time of the first state after the clear, plant's clock; None: open
        self._is_open = True

    @property
    def is_open(self) -> bool:
        """True if commands count."""
        return self._is_open

    def observe(self, header: Header, state: PlantState) -> bool:
        """Learn from the newest plant state.

        Args:
            header: Header of its message.
            state: The state.

        Returns:
            Whether inputs sent before are void: a stop was latched or cleared since the state before.
        """
        if header.epoch != self._plant_epoch:
            self.restart()
            self._plant_epoch = header.epoch
        is_stopped = state.stop != 0
        changed = is_stopped != self.is_stopped or state.stops_cleared != self.cleared
        if changed:
            self.is_stopped, self.cleared = is_stopped, state.stops_cleared
            self._is_open, self._cleared_ns = False, header.scheduled_ns
        return changed

    def opens(self, command: OperatorCommand) -> bool:
        """Return whether the gate opens with this command, and open it.

        Args:
            command: The newest command of the operator.
        """
        if self._is_open or self.is_stopped or self._cleared_ns is None:
            return False
        if command.echoed_epoch:
            self._is_open = command.echoed_epoch == self._plant_epoch and command.echoed_ns >= self._cleared_ns
        else:
            self._is_open = not command.enabled
        return self._is_open

    def pass_on(self, command: OperatorCommand) -> OperatorCommand:
        """Return the command as it counts: as it is, or as released while the gate is closed."""
        return command if self._is_open else replace(command, enabled=False)
