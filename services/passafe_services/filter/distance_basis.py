"""Decision whose distance to infeasibility a tick reports."""

from typing import Final

from passafe.decision import Decision

PERIOD_NS: Final = 20_000_000
"""Plant time after which a tick's own decision is taken again, ns."""


class DistanceBasis:
    """Selects the decisions whose distance is computed: one in 20 ms, and every one in a fallback and after it.

    Among three disks and four walls the linear program takes five times as long as the decision.
    """

    def __init__(self) -> None:
        self._basis: Decision | None = None
        self._effective_ns = 0

    def of(self, decision: Decision, effective_ns: int) -> Decision:
        """Return the decision whose distance the tick of a decision reports, itself or an earlier one.

        Args:
            decision: The newest.
            effective_ns: Plant time at which it takes effect, ns.
        """
        basis = self._basis
        if (
            basis is None
            or basis.status.is_fallback
            or decision.status.is_fallback
            or not 0 <= effective_ns - self._effective_ns < PERIOD_NS
        ):
            basis = self._basis = decision
            self._effective_ns = effective_ns
        return basis
