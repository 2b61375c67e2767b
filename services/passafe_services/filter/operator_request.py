"""What the operator asks for at a tick: newest command, its age, dead-man, and what lies between commands."""

from math import isfinite

from passafe_protocol.messages import OperatorCommand, Received, Vector

from passafe.human_input import HumanInputEstimator
from passafe_services.filter.sender_clock import SenderClock

Request = tuple[Vector, Vector, int, bool]
"""u_h, its rate, the age of the newest command in ns (−1 without one) and whether that is stale."""


class PassThroughRequest:
    """The newest command's u_h and rate as they are; without a rate in it, zero.

    From the moment at which the newest command is stale or the dead-man is released, what was asked for last fades
    to zero along a straight line: u_h(t) = (1 − t/T)·u_h(0). A command of the wrong shape or with a number that is not
    finite is passed over.
    """

    def __init__(self, inputs: int, stale_ns: int, fade_ns: int) -> None:
        """Start with nothing heard.

        Args:
            inputs: m.
            stale_ns: Age from which a command is stale, ns.
            fade_ns: T, how long it takes until nothing is asked for, ns.
        """
        self._m = inputs
        self._rate_lengths = (0, inputs)
        self._stale_ns = stale_ns
        self._fade_ns = fade_ns
        self._zero: Vector = (0.0,) * inputs
        self.restart()

    def restart(self) -> None:
        """Forget everything heard."""
        self._ends_ns = 0  # when what was asked for last ended, once it has
        self._given = self._zero
        self._command: OperatorCommand | None = None
        self._order = (-1, -1)
        self._received_ns = 0

    def hear(self, received: Received, command: OperatorCommand) -> None:
        """Take in a command; one that a newer one overtook changes nothing.

        Args:
            received: The message.
            command: Its body.
        """
        header = received.header
        order = (header.epoch, header.sequence)
        if order > self._order and self._is_request(command):
            self._take(received, command, order)

    def at(self, now_ns: int) -> Request:
        """Return what is asked for at a tick.

        Args:
            now_ns: When the tick is due, monotonic, ns.
        """
        command = self._command
        if command is None:
            return self._zero, self._zero, -1, True
        age_ns = now_ns - self._received_ns if now_ns > self._received_ns else 0
        if age_ns > self._stale_ns or not command.enabled:
            ended_ns = self._received_ns + self._stale_ns if command.enabled else self._ends_ns
            return *self._faded(now_ns - ended_ns), age_ns, age_ns > self._stale_ns
        self._given = command.u_h
        return command.u_h, command.u_h_rate or self._zero, age_ns, False

    def _take(self, received: Received, command: OperatorCommand, order: tuple[int, int]) -> None:
        """Put a command in the place of the one before."""
        before = self._command
        if not command.enabled and (before is None or before.enabled):
            self._ends_ns = received.received_ns
            if before is not None:  # it may have been stale before the dead-man was released
                self._ends_ns = min(self._ends_ns, self._received_ns + self._stale_ns)
        self._command, self._order, self._received_ns = command, order, received.received_ns

    def _faded(self, elapsed_ns: int) -> tuple[Vector, Vector]:
        """Return what is left of what was asked for last, and its rate."""
        left_ns = self._fade_ns - max(elapsed_ns, 0)
        if left_ns <= 0:
            return self._zero, self._zero
        share, rate = left_ns / self._fade_ns, -1e9 / self._fade_ns
        return tuple([share * value for value in self._given]), tuple([rate * value for value in self._given])

    def _is_request(self, command: OperatorCommand) -> bool:
        """Tell whether a command has the filter's shape and only finite numbers."""
        u_h, rate = command.u_h, command.u_h_rate
        return len(u_h) == self._m and len(rate) in self._rate_lengths and isfinite(sum(u_h + rate))


class EstimatedRequest(PassThroughRequest):
    """u_h and its rate at the tick, estimated from the commands' u_h; a rate that the device tells is not used.

    An overtaken command still counts as a sample. The estimator starts anew after a released dead-man, after
    silence of ``stale_ns``, with another session, and where the sender's clock does not run on. All of that is told
    from the messages alone: which ticks asked in between changes nothing, so a log can be stepped again.
    """

    def __init__(self, inputs: int, stale_ns: int, fade_ns: int, estimator: HumanInputEstimator) -> None:
        """Start with nothing heard.

        Args:
            inputs: m.
            stale_ns: Age from which a command is stale, ns.
            fade_ns: How long it takes until nothing is asked for, ns.
            estimator: Of m axes.
        """
        self._estimator = estimator
        self._clock = SenderClock()
        super().__init__(inputs, stale_ns, fade_ns)

    def restart(self) -> None:
        """See ``PassThroughRequest``."""
        super().restart()
        self._start_anew((-1, -1))

    def hear(self, received: Received, command: OperatorCommand) -> None:
        """Take in a command as a sample, newest or not.

        Args:
            received: The message.
            command: Its body.
        """
        if not self._is_request(command):
            return
        header = received.header
        order = (header.epoch, header.sequence)
        if order > self._order:
            if (
                header.epoch != self._order[0]
                or not command.enabled
                or received.received_ns - self._received_ns > self._stale_ns
                or not self._clock.runs_on(header.scheduled_ns)
            ):
                self._start_anew(order)
            self._take(received, command, order)
        elif order <= self._since:
            return
        if not command.enabled:
            return
        delay_ns = self._clock.hear(header.scheduled_ns, received.received_ns)
        if order == self._order and delay_ns > self._stale_ns:  # no link keeps the newest so long: the clock jumped
            self._start_anew(order)
            self._clock.hear(header.scheduled_ns, received.received_ns)
        self._estimator.add(self._clock.sent_s(header.scheduled_ns), command.u_h)

    def at(self, now_ns: int) -> Request:
        """Return the estimate at a tick, and where ``PassThroughRequest`` fades, what is left of the last one.

        Args:
            now_ns: When the tick is due, monotonic, ns.
        """
        _, _, age_ns, stale = asked = super().at(now_ns)
        if stale or self._command is None or not self._command.enabled:
            return asked
        u_h, u_h_rate = self._estimator.at(self._clock.now_s(now_ns))
        self._given = u_h
        return u_h, u_h_rate, age_ns, False

    def _start_anew(self, order: tuple[int, int]) -> None:
        """Forget all samples; commands before ``order`` count no more."""
        self._since = order
        self._estimator.restart()
        self._clock.restart()
