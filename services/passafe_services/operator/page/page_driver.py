"""Page as a command source: its newest command drives while it is fresh, in order and held."""

from typing import Final

from passafe_protocol.messages import Received, Steer, Vector, WhoDrives

from passafe_services.operator.sources.command import Command
from passafe_services.operator.sources.follower import Follower

DEVICE: Final = "page"
FRESH_NS: Final = 250_000_000
"""Age from which a command of a page no longer drives."""

FOLLOW_S: Final = 0.02
"""Time constant with which u_h follows the page, whose commands come in steps of a sixtieth of a second."""


class PageDriver:
    """Driver that the page names: the page itself, nobody, or the operator's own source.

    Until a first ``Steer`` the operator's own source drives. Once a page has taken its place, the source drives again
    only when the page hands back to it: a page that releases, falls silent or vanishes leaves nobody at the wheel.

    A command of a page drives for ``FRESH_NS`` after it was made. Its age is bounded by what the dashboard says of it
    and, for the way to here, by the echo of a command of this session; without that echo it does not drive. Once a
    command that drove became too old, the dead-man has to be let go before the page drives again in the same turn.

    Attributes:
        take_overs: Turns so far that ask for the lease of another operator.
    """

    def __init__(self, authority: Vector, *, epoch: int) -> None:
        """Start without a page.

        Args:
            authority: Largest |u_h| of each axis, units of u.
            epoch: Session of the operator.
        """
        self.take_overs = 0
        self._authority = authority
        self._rest: Vector = (0.0,) * len(authority)
        self._epoch = epoch
        self._number = (-1, -1)
        self._turn = (-1, 0)
        self._steer: Steer | None = None
        self._until_ns = 0
        self._follower = Follower(len(authority), FOLLOW_S)
        self._driving_ns: int | None = None
        self._must_release = False

    @property
    def commands(self) -> bool:
        """True while the command is the page's, or nobody's, rather than the source's."""
        return self._steer is not None and self._steer.driver != WhoDrives.SCRIPT

    def receive(self, received: Received, steer: Steer) -> None:
        """Keep a newer message of the page.

        Args:
            received: The message.
            steer: Its body.
        """
        number = (received.term, received.header.sequence)
        if number <= self._number:
            return
        self._number = number
        turn = (received.term, steer.turn)
        if turn != self._turn:
            self._turn = turn
            self._must_release = False
            self.take_overs += steer.take_over
        self._steer = steer
        self._until_ns = self._fresh_until_ns(received.received_ns, steer)
        if not steer.engaged and received.received_ns <= self._until_ns:
            self._must_release = False

    def command(self, now_ns: int) -> Command:
        """Return the command at a monotonic time, ns: a released zero unless the page drives."""
        steer = self._steer
        engaged = steer is not None and steer.driver == WhoDrives.PAGE and steer.engaged
        fresh = engaged and now_ns <= self._until_ns
        if self._driving_ns is not None and engaged and not fresh:
            self._must_release = True
        if steer is None or not fresh or self._must_release or len(steer.shares) != len(self._rest):
            self._driving_ns = None
            self._follower.rest()
            return Command(self._rest, self._rest, enabled=False)
        if self._driving_ns is not None:
            self._follower.advance((now_ns - self._driving_ns) / 1e9)
        self._driving_ns = now_ns
        self._follower.aim([share * full for share, full in zip(steer.shares, self._authority, strict=True)])
        return Command(self._follower.value, self._follower.rate, enabled=True)

    def _fresh_until_ns(self, received_ns: int, steer: Steer) -> int:
        """Return the time until which a command drives; one of which the age is not known does not drive at all."""
        if steer.echoed_epoch != self._epoch:
            return received_ns - 1
        way_ns = max(received_ns - steer.echoed_ns - steer.echoed_for_ns, 0)
        return received_ns - steer.age_ns - way_ns + FRESH_NS
