"""Operator's request at a tick, from the newest command or an estimate between commands, with fade and ramp."""

from math import isfinite
from typing import Final

from msgspec import Struct
from passafe_protocol.messages import CommandState, OperatorCommand, Received, Vector

from passafe.human_input import HumanInputEstimator
from passafe_services.filter.dead_man import DeadManFade
from passafe_services.filter.newest_command import NewestCommand, Reception
from passafe_services.filter.resume_ramp import ResumeRamp
from passafe_services.filter.sender_clock import SenderClock

_STALE: Final = frozenset({CommandState.NONE, CommandState.SILENT, CommandState.DELAYED})
_COUNTS: Final = CommandState.COUNTS


class OperatorRequest(Struct, frozen=True, gc=False):
    """The operator's request at a tick; a struct, because every step makes one.

    Attributes:
        u_h: m numbers, units of u.
        u_h_rate: Its rate, m numbers, units of u per second.
        age_ns: Age of the newest command since it was sent, ns; −1 before the first.
        state: Whether the command counts, and otherwise why not.
        share: Share of the command in ``u_h``: 1 in full, 0 if it does not count, between while it ramps in.
    """

    u_h: Vector
    u_h_rate: Vector
    age_ns: int
    state: CommandState
    share: float

    @property
    def is_stale(self) -> bool:
        """True if there is no command that is new enough."""
        return self.state in _STALE


class PassThroughRequest:
    """Passes u_h and rate of the newest command through; a missing rate is zero.

    Once the newest command is stale or the dead-man switch is released, the last request fades to zero
    (``DeadManFade``). After a stale stretch commands ramp in (``ResumeRamp``). A command with the wrong shape or a
    number that is not finite is ignored.
    """

    def __init__(self, inputs: int, newest: NewestCommand, fade: DeadManFade, ramp: ResumeRamp) -> None:
        """Start with nothing received.

        Args:
            inputs: m.
            newest: Decides which commands count.
            fade: Fade of the request when none does.
            ramp: Ramp of the request when they do again.
        """
        self._m = inputs
        self._zero: Vector = (0.0,) * inputs
        self._newest = newest
        self._dead_man = fade
        self._ramp = ramp
        self.restart()

    def restart(self) -> None:
        """Discard all commands."""
        self._newest.restart()
        self._dead_man.restart()
        self._ramp.restart()

    def begin_session(self) -> None:
        """Begin with the commands of another sender: its first one that counts ramps in, what was before fades."""
        self._newest.begin_session()

    def void(self) -> None:
        """Discard what was requested so far, its fade included: an emergency stop was latched or cleared."""
        self._newest.release()
        self._dead_man.restart()
        self._ramp.restart()

    def begin(self) -> None:
        """Let the next command that counts ramp in from its beginning."""
        self._newest.begin()

    def receive(self, received: Received, command: OperatorCommand) -> None:
        """Receive a command; one older than the newest is ignored.

        Args:
            received: The message.
            command: Its body.
        """
        header = received.header
        if (header.epoch, header.sequence) > self._newest.order and self._is_valid(command):
            self._replace(received, command)

    def at(self, now_ns: int) -> OperatorRequest:
        """Return the request at a tick.

        Args:
            now_ns: Time at which the tick is due, monotonic, ns.
        """
        newest = self._newest
        age_ns, state, command = newest.age_ns(now_ns), newest.state(now_ns), newest.body
        if command is None:
            return OperatorRequest(self._zero, self._zero, age_ns, state, 0.0)
        if state is not _COUNTS:
            released_ns = newest.expires_ns if command.enabled else self._dead_man.released_ns
            return OperatorRequest(*self._dead_man.at(now_ns - released_ns), age_ns, state, 0.0)
        u_h, u_h_rate = self._requested(now_ns, command)
        share = self._ramp.share(now_ns)
        if share < 1.0:
            u_h, u_h_rate = self._ramp.blend(share, now_ns, u_h, u_h_rate)
            state = CommandState.RESUMES
        self._dead_man.last_u_h = u_h
        return OperatorRequest(u_h, u_h_rate, age_ns, state, share)

    def _requested(self, now_ns: int, command: OperatorCommand) -> tuple[Vector, Vector]:
        """Return what the operator requests while the command counts: u_h and its rate."""
        del now_ns
        return command.u_h, command.u_h_rate or self._zero

    def _replace(self, received: Received, command: OperatorCommand) -> Reception:
        """Replace the newest command; return whether it counts."""
        before, released_ns = self._newest.body, received.received_ns
        if before is not None:  # it may have become stale before
            released_ns = min(released_ns, self._newest.expires_ns)
        reception = self._newest.receive(received, command)
        ramps_in = reception.ramps_in
        if (ramps_in or not command.enabled) and (before is None or before.enabled):  # else the fade is under way
            self._dead_man.released_ns = released_ns
        if ramps_in:
            anew = before is None or reception is Reception.BEGINS
            self._ramp.begin(received.received_ns, self._dead_man, command.u_h, anew=anew)
        return reception

    def _is_valid(self, command: OperatorCommand) -> bool:
        """Check that a command has the filter's shape and only finite numbers."""
        u_h, rate = command.u_h, command.u_h_rate
        return len(u_h) == self._m and len(rate) in {0, self._m} and isfinite(sum(rate, sum(u_h)))


class EstimatedRequest(PassThroughRequest):
    """Estimates u_h and its rate at the tick from the u_h of the commands; rates of the device are not used.

    A reordered command still counts as a sample unless it is stale. The estimator restarts after a release of the
    dead-man switch, after a stale stretch, with a new session, and when the sender's clock does not advance. All of
    this depends on the messages alone, not on the ticks in between, so replay is exact.
    """

    def __init__(
        self, inputs: int, newest: NewestCommand, fade: DeadManFade, ramp: ResumeRamp, estimator: HumanInputEstimator
    ) -> None:
        """Start with nothing received.

        Args:
            inputs: m.
            newest: Decides which commands count.
            fade: Fade of the request when none does.
            ramp: Ramp of the request when they do again.
            estimator: Estimator of m axes.
        """
        self._estimator = estimator
        self._clock = SenderClock()
        super().__init__(inputs, newest, fade, ramp)

    def restart(self) -> None:
        """See ``PassThroughRequest``."""
        super().restart()
        self._reset_estimator((-1, -1))

    def void(self) -> None:
        """See ``PassThroughRequest``."""
        super().void()
        self._reset_estimator(self._newest.order)

    def receive(self, received: Received, command: OperatorCommand) -> None:
        """Receive a command as a sample, newest or not.

        Args:
            received: The message.
            command: Its body.
        """
        if not self._is_valid(command):
            return
        header, before = received.header, self._newest.order
        order = (header.epoch, header.sequence)
        if order > before:
            reception = self._replace(received, command)
            if reception is Reception.LATE and command.enabled:
                return
            if (
                header.epoch != before[0]
                or not command.enabled
                or reception.ramps_in
                or not self._clock.advances(header.scheduled_ns)
            ):
                self._reset_estimator(order)
        elif order <= self._since:
            return
        if command.enabled and self._newest.is_recent(self._clock.update(header.scheduled_ns, received.received_ns)):
            self._estimator.add(self._clock.sent_s(header.scheduled_ns), command.u_h)

    def _requested(self, now_ns: int, command: OperatorCommand) -> tuple[Vector, Vector]:
        del command
        return self._estimator.at(self._clock.now_s(now_ns))

    def _reset_estimator(self, order: tuple[int, int]) -> None:
        """Discard all samples; commands before ``order`` are ignored from now on."""
        self._since = order
        self._estimator.restart()
        self._clock.restart()
