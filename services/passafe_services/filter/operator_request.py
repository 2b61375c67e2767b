"""Operator's request at a tick, from the newest command or an estimate between commands, with the dead-man fade."""

from math import isfinite

from passafe_protocol.messages import OperatorCommand, Received, Vector

from passafe.human_input import HumanInputEstimator
from passafe_services.filter.dead_man import DeadManFade
from passafe_services.filter.sender_clock import SenderClock

Request = tuple[Vector, Vector, int, bool]
"""u_h, its rate, the age of the newest command in ns (−1 without one) and whether it is stale."""


class PassThroughRequest:
    """Passes u_h and rate of the newest command through; a missing rate is zero.

    Once the newest command is stale or the dead-man switch is released, the last request fades to zero
    (``DeadManFade``). A command with the wrong shape or a number that is not finite is ignored.
    """

    def __init__(self, inputs: int, stale_ns: int, fade_ns: int) -> None:
        """Start with nothing received.

        Args:
            inputs: m.
            stale_ns: Age above which a command is stale, ns.
            fade_ns: Time in which the request fades to zero, ns.
        """
        self._m = inputs
        self._rate_lengths = (0, inputs)
        self._stale_ns = stale_ns
        self._dead_man = DeadManFade(inputs, fade_ns)
        self._zero: Vector = (0.0,) * inputs
        self.restart()

    def restart(self) -> None:
        """Discard all commands."""
        self._dead_man.restart()
        self._command: OperatorCommand | None = None
        self._order = (-1, -1)
        self._received_ns = 0

    def receive(self, received: Received, command: OperatorCommand) -> None:
        """Receive a command; one older than the newest is ignored.

        Args:
            received: The message.
            command: Its body.
        """
        header = received.header
        order = (header.epoch, header.sequence)
        if order > self._order and self._is_valid(command):
            self._replace(received, command, order)

    def at(self, now_ns: int) -> Request:
        """Return the request at a tick.

        Args:
            now_ns: Time at which the tick is due, monotonic, ns.
        """
        command = self._command
        if command is None:
            return self._zero, self._zero, -1, True
        age_ns = now_ns - self._received_ns if now_ns > self._received_ns else 0
        if age_ns > self._stale_ns or not command.enabled:
            released_ns = self._received_ns + self._stale_ns if command.enabled else self._dead_man.released_ns
            return *self._dead_man.at(now_ns - released_ns), age_ns, age_ns > self._stale_ns
        self._dead_man.last_u_h = command.u_h
        return command.u_h, command.u_h_rate or self._zero, age_ns, False

    def _replace(self, received: Received, command: OperatorCommand, order: tuple[int, int]) -> None:
        """Replace the newest command."""
        before = self._command
        if not command.enabled and (before is None or before.enabled):
            released_ns = received.received_ns
            if before is not None:  # the previous command may have become stale before the release
                released_ns = min(released_ns, self._received_ns + self._stale_ns)
            self._dead_man.released_ns = released_ns
        self._command, self._order, self._received_ns = command, order, received.received_ns

    def _is_valid(self, command: OperatorCommand) -> bool:
        """Check that a command has the filter's shape and only finite numbers."""
        u_h, rate = command.u_h, command.u_h_rate
        return len(u_h) == self._m and len(rate) in self._rate_lengths and isfinite(sum(u_h + rate))


class EstimatedRequest(PassThroughRequest):
    """Estimates u_h and its rate at the tick from the u_h of the commands; rates of the device are not used.

    A reordered command still counts as a sample. The estimator restarts after a release of the dead-man switch, after
    silence of ``stale_ns``, with a new session, and when the sender's clock does not advance. All of this depends on
    the messages alone, not on the ticks in between, so replay is exact.
    """

    def __init__(self, inputs: int, stale_ns: int, fade_ns: int, estimator: HumanInputEstimator) -> None:
        """Start with nothing received.

        Args:
            inputs: m.
            stale_ns: Age above which a command is stale, ns.
            fade_ns: Time in which the request fades to zero, ns.
            estimator: Estimator of m axes.
        """
        self._estimator = estimator
        self._clock = SenderClock()
        super().__init__(inputs, stale_ns, fade_ns)

    def restart(self) -> None:
        """See ``PassThroughRequest``."""
        super().restart()
        self._reset_estimator((-1, -1))

    def receive(self, received: Received, command: OperatorCommand) -> None:
        """Receive a command as a sample, newest or not.

        Args:
            received: The message.
            command: Its body.
        """
        if not self._is_valid(command):
            return
        header = received.header
        order = (header.epoch, header.sequence)
        if order > self._order:
            if (
                header.epoch != self._order[0]
                or not command.enabled
                or received.received_ns - self._received_ns > self._stale_ns
                or not self._clock.advances(header.scheduled_ns)
            ):
                self._reset_estimator(order)
            self._replace(received, command, order)
        elif order <= self._since:
            return
        if not command.enabled:
            return
        delay_ns = self._clock.update(header.scheduled_ns, received.received_ns)
        if order == self._order and delay_ns > self._stale_ns:  # a clock jump: no link delays the newest so long
            self._reset_estimator(order)
            self._clock.update(header.scheduled_ns, received.received_ns)
        self._estimator.add(self._clock.sent_s(header.scheduled_ns), command.u_h)

    def at(self, now_ns: int) -> Request:
        """Return the estimate at a tick; the last one fades as in ``PassThroughRequest``.

        Args:
            now_ns: Time at which the tick is due, monotonic, ns.
        """
        _, _, age_ns, stale = request = super().at(now_ns)
        if stale or self._command is None or not self._command.enabled:
            return request
        u_h, u_h_rate = self._estimator.at(self._clock.now_s(now_ns))
        self._dead_man.last_u_h = u_h
        return u_h, u_h_rate, age_ns, False

    def _reset_estimator(self, order: tuple[int, int]) -> None:
        """Discard all samples; commands before ``order`` are ignored from now on."""
        self._since = order
        self._estimator.restart()
        self._clock.restart()
