"""Record of the filter's decisions of a run, from its ticks as they come."""

from collections import Counter
from typing import ClassVar

import numpy as np
from passafe_protocol.topics import TICK

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice
from passafe_services.tools.review.command_use import CommandUse
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.energy_account import EnergyInProgress
from passafe_services.tools.review.fallback_record import FallbackRecord
from passafe_services.tools.review.filter_claims import Decisions
from passafe_services.tools.review.properties import judge_certificates
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.trajectory import NS_PER_S


class DecisionRecord:
    """Record of the decisions of a run.

    Args:
        period_ns: Period of a tick, ns.
        limit: Largest residual and gap of a certificate.
        energy: Takes the slacks.
        drive: Takes the statuses.

    Attributes:
        ticks: Number of ticks.
        fallbacks: Those in a fallback.
    """

    wants: ClassVar[Wants] = {
        TICK.name: (
            *("status", "effective_plant_ns", "slack", "command_age_ns", "state_age_ns", "command_state"),
            *(f"certificate.{part}" for part in ("accepted", "primal_residual", "dual_residual", "gap")),
        )
    }

    def __init__(self, period_ns: int, limit: float, energy: EnergyInProgress, drive: DriveRecord) -> None:
        self.ticks = 0
        self.fallbacks = FallbackRecord(period_ns)
        self._limit = limit
        self._energy = energy
        self._drive = drive
        self._statuses: Counter[str] = Counter()
        self._commands: Counter[str] = Counter()
        self._uncertified = 0
        self._first_uncertified_s: float | None = None

    def take(self, part: LogSlice) -> None:
        """Take the next ticks."""
        for block in part.blocks(TICK.name):
            decisions = Decisions.in_block(block)
            status, at_ns = decisions.status, decisions.at_ns
            self.ticks += at_ns.size
            self.fallbacks.add_all(status, at_ns)
            self._drive.add_ticks(status, at_ns)
            self._energy.decide(at_ns, decisions.slack_w)
            self._statuses.update(decisions.counts)
            states = block.texts("command_state")
            for word in states.words:
                if word:
                    self._commands[word] += int(np.count_nonzero(states.are(word)))
            uncertified = decisions.uncertified(self._limit)
            self._uncertified += int(uncertified.sum())
            if self._first_uncertified_s is None and uncertified.any():
                self._first_uncertified_s = float(at_ns[uncertified.argmax()] / NS_PER_S)

    @property
    def status_counts(self) -> dict[str, int]:
        """Number of ticks of each status, in the order of first occurrence."""
        return dict(self._statuses)

    @property
    def commands(self) -> CommandUse:
        """Use of the operator's commands."""
        return CommandUse.counted(self._commands)

    def certified(self, *, required: bool) -> Property:
        """Return the property that solutions had certificates."""
        return judge_certificates(
            self.ticks, self._uncertified, self._first_uncertified_s, self._limit, required=required
        )
