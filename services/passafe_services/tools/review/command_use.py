"""Share of a run in which the operator's command counted, and the reasons why it did not."""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Final, Self

from passafe_protocol.messages import CommandState, FilterTick
from pydantic import BaseModel, ConfigDict

WORDS: Final[Mapping[CommandState, str]] = {
    CommandState.COUNTS: "counted",
    CommandState.RESUMES: "ramped in after a stale stretch",
    CommandState.RELEASED: "dead-man released",
    CommandState.DELAYED: "too old when they arrived",
    CommandState.SILENT: "no newer one came",
    CommandState.STOPPED: "emergency stop",
    CommandState.NONE: "none yet",
}

_LEAST: Final = 0.001
"""Share below which a number would read as none."""


class CommandUse(BaseModel):
    """Use of the operator's commands over a run.

    Attributes:
        shares: Share of the ticks by ``FilterTick.command_state``; empty for a log that does not tell.
        text: The same in words.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    shares: dict[str, float]
    text: str

    @classmethod
    def of(cls, ticks: Iterable[FilterTick]) -> Self:
        """Return the use of the commands in these ticks."""
        return cls.counted(Counter(tick.command_state for tick in ticks if tick.command_state))

    @classmethod
    def counted(cls, counts: Counter[str]) -> Self:
        """Return the use of the commands in ticks that were counted by their ``command_state``."""
        shares = {state.value: counts[state] / counts.total() for state in WORDS if counts[state]}
        parts = [f"{WORDS[CommandState(state)]} {_percent(share)}" for state, share in shares.items()]
        return cls(shares=shares, text=", ".join(parts) or "not in this log")


def _percent(share: float) -> str:
    """Return a share of ticks in percent; what is there at all is never shown as nothing, nor as everything."""
    if share < _LEAST:
        return "< 0.1 %"
    return "> 99.9 %" if 1.0 - _LEAST < share < 1.0 else f"{100 * share:.3g} %"
