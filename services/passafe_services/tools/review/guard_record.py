"""Record of the guard at the plant: what share of the inputs it changed, and for which rows."""

from collections import Counter
from typing import ClassVar

import numpy as np
from passafe_protocol.messages import GuardAction
from passafe_protocol.topics import STATE
from pydantic import BaseModel, ConfigDict

from passafe_services.log.chunk_decoding import Wants
from passafe_services.log.log_pass import LogSlice


class GuardAccount(BaseModel):
    """Account of the guard of a run.

    Attributes:
        passed: States whose input passed, to the last bit.
        changed: States whose input it changed to the nearest that keeps every row.
        fail_safe: States in which no input was certified, and the core's fallback acted.
        causes: States by the row for which it acted.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    passed: int
    changed: int
    fail_safe: int
    causes: dict[str, int]

    @property
    def share(self) -> float:
        """Return the share of the inputs that it did not pass."""
        acted = self.changed + self.fail_safe
        return acted / max(acted + self.passed, 1)

    def in_words(self) -> str:
        """Return the same in a sentence."""
        total = self.passed + self.changed + self.fail_safe
        causes = ", ".join(f"{name} {count}" for name, count in self.causes.items())
        said = f"changed {self.changed + self.fail_safe} of {total} inputs ({100 * self.share:.2g} %)"
        return f"{said}: {causes}" if causes else said


class GuardRecord:
    """Record of the guard, from the plant's states as they come."""

    wants: ClassVar[Wants] = {STATE.name: ("guard", "guard_cause")}

    def __init__(self) -> None:
        self._actions: Counter[str] = Counter()
        self._causes: Counter[str] = Counter()

    def take(self, part: LogSlice) -> None:
        """Take the next states."""
        for block in part.blocks(STATE.name):
            for action in filter(None, GuardAction):
                self._actions[action] += int(block.texts("guard").are(action).sum())
            causes = block.texts("guard_cause")
            for cause in filter(None, causes.words):
                self._causes[cause] += int(np.sum(causes.are(cause)))

    def account(self) -> GuardAccount | None:
        """Return what it did; ``None`` without a guard."""
        if not self._actions.total():
            return None
        return GuardAccount(
            passed=self._actions[GuardAction.PASSED],
            changed=self._actions[GuardAction.CHANGED],
            fail_safe=self._actions[GuardAction.FAIL_SAFE],
            causes={cause: count for cause, count in self._causes.most_common() if count},
        )
