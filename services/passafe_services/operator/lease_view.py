"""View of an operator on the lease: whether its commands count, and whose do."""

from passafe_protocol.messages import Event, OperatorLease


class LeaseView:
    """View of one operator session on the lease that the filter grants.

    A session sends unless it knows that another one holds the lease; then it waits, unless it asks to take over. A
    request to take over is over when the session holds the lease; if it loses that later, it waits.
    """

    def __init__(self, epoch: int, *, takes_over: bool) -> None:
        """Start without knowledge.

        Args:
            epoch: The session.
            takes_over: Whether it asks to take over from the session that holds the lease.
        """
        self._epoch = epoch
        self._wants = takes_over
        self._lease: OperatorLease | None = None
        self._reported = epoch

    def receive(self, lease: OperatorLease) -> None:
        """Keep the newest lease."""
        self._lease = lease
        if lease.holder == self._epoch:
            self._wants = False

    def take_over(self) -> None:
        """Ask to take over from the session that holds the lease, if another one does."""
        self._wants = self.is_waiting

    @property
    def is_waiting(self) -> bool:
        """True if another session holds the lease."""
        return self._lease is not None and self._lease.holder not in {0, self._epoch}

    @property
    def holder(self) -> str:
        """The other session that holds the lease, in words; empty if none is known."""
        lease = self._lease
        return f"session {lease.holder} ({lease.device})" if lease is not None and self.is_waiting else ""

    @property
    def sends(self) -> bool:
        """True if the session sends commands."""
        return self._wants or not self.is_waiting

    @property
    def requested(self) -> int:
        """Number of the lease that it asks to take over; 0: none."""
        return self._lease.number if self._lease is not None and self._wants and self.is_waiting else 0

    def event(self) -> Event | None:
        """Return an event if the lease went to another session since the last call, or came back."""
        now = self._lease.holder if self._lease is not None and self.is_waiting else self._epoch
        if now == self._reported:
            return None
        self._reported = now
        if now == self._epoch:
            return Event("info", f"operator session {self._epoch} waits no longer")
        return Event("warning", f"operator session {self._epoch} sends nothing: {self.holder} holds the lease")
