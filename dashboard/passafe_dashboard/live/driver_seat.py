"""Seat of the one page that drives: who has it, since when, and its newest command. Pure, without a clock."""

from dataclasses import dataclass
from typing import Final

from passafe_protocol.messages import OperatorLease, Steer, Vector, WhoDrives

DEVICE: Final = "page"
"""Device of the operator's commands while a page drives."""

FRESH_NS: Final = 250_000_000
"""Age from which a command of a page no longer drives."""

SILENT_NS: Final = 2_000_000_000
"""Time without a fresh command after which the page that drives loses the seat.

A busy machine delays a page by more than ``FRESH_NS`` now and then; it need not take the wheel anew each time.
"""

ANSWER_NS: Final = 2_000_000_000
"""Time for the operator to follow a page that took the seat."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PageCommand:
    """Command of a page.

    Attributes:
        shares: Share of the authority of each input, −1 to 1.
        engaged: Whether the dead-man is held.
        made_ns: When it was made, at the latest; server's monotonic clock.
    """

    shares: Vector
    engaged: bool
    made_ns: int


class DriverSeat:
    """Seat that one page has at a time, nobody, or the operator's own script.

    A page takes it when it is free, or from another page or another operator if it says so. It loses it by releasing,
    by closing its connection, by ``SILENT_NS`` without a fresh command, or to another operator; then nobody has it.

    Attributes:
        who: Who drives; ``None`` while no page took the seat: the operator's own source does.
        page: Number of the page that has it; 0: none.
        turn: Counts the changes.
        since_ns: When it changed last, server's monotonic clock.
        reason: Why, in words.
        pages: Number of connected pages that may drive.
    """

    def __init__(self) -> None:
        """Start with a seat that no page has had."""
        self.who: WhoDrives | None = None
        self.page = 0
        self.turn = 0
        self.since_ns = 0
        self.reason = ""
        self.pages = 0
        self._takes_over = False
        self._followed = False
        self._command: PageCommand | None = None
        self._fresh_ns = 0

    def take(self, page: int, now_ns: int, *, over: bool, other: str) -> str:
        """Let a page take the seat.

        Args:
            page: Its number, from 1.
            now_ns: Server's monotonic clock.
            over: Whether it takes it from another page or operator.
            other: Device of another operator, which holds the lease; empty: none does.

        Returns:
            Why it does not get it; empty if it does.
        """
        if self.page == page:
            return ""
        if not over and self.page:
            return f"page {self.page} drives"
        if not over and other:
            return f"another operator drives ({other})"
        self._change(WhoDrives.PAGE, page, now_ns, f"taken by page {page}")
        self._takes_over = over
        return ""

    def steer(self, page: int, command: PageCommand, now_ns: int) -> bool:
        """Keep a command of a page; return whether it counts: the page has the seat, and the command is fresh."""
        if page != self.page or now_ns - command.made_ns > FRESH_NS or self.expire(now_ns):
            return False
        self._command, self._fresh_ns = command, command.made_ns
        return True

    def release(self, page: int, now_ns: int, reason: str = "released") -> bool:
        """Free the seat of a page; return whether it had it."""
        if page != self.page or not page:
            return False
        self._change(WhoDrives.NOBODY, 0, now_ns, reason)
        return True

    def hand_to_script(self, page: int, now_ns: int) -> str:
        """Hand the seat to the operator's script; return why a page may not, or nothing."""
        if self.page not in {0, page}:
            return f"page {self.page} drives"
        if self.who not in {None, WhoDrives.SCRIPT}:
            self._change(WhoDrives.SCRIPT, 0, now_ns, f"handed to the script by page {page}")
        return ""

    def expire(self, now_ns: int) -> bool:
        """Free the seat of a page that is silent; return whether it was."""
        return now_ns - self._fresh_ns > SILENT_NS and self.release(self.page, now_ns, "the page was silent")

    def observe(self, lease: OperatorLease, now_ns: int) -> bool:
        """Free the seat if another operator holds the lease; return whether it does.

        The operator has ``ANSWER_NS`` to follow.
        """
        if not self.page or not lease.holder:
            return False
        if lease.device == DEVICE:
            self._followed = True
            return False
        if self._followed:
            return self.release(self.page, now_ns, f"another operator took over ({lease.device})")
        waited = now_ns - self.since_ns > ANSWER_NS
        return waited and self.release(self.page, now_ns, f"another operator drives ({lease.device})")

    def message(self, now_ns: int, echo: tuple[int, int, int]) -> Steer | None:
        """Return what the operator is to know now; ``None`` while no page took the seat.

        Args:
            now_ns: Server's monotonic clock.
            echo: Session and ``scheduled_ns`` of the newest command of an operator, and the time since its arrival, ns.
        """
        if self.who is None:
            return None
        command = self._command
        if command is None:
            return Steer(self.turn, self.who, self.page, (), False, 0, self._takes_over, *echo)
        age_ns = max(now_ns - command.made_ns, 0)
        return Steer(self.turn, self.who, self.page, command.shares, command.engaged, age_ns, self._takes_over, *echo)

    def _change(self, who: WhoDrives, page: int, now_ns: int, reason: str) -> None:
        self.who, self.page, self.since_ns, self.reason = who, page, now_ns, reason
        self.turn += 1
        self._takes_over = self._followed = False
        self._command, self._fresh_ns = None, now_ns
