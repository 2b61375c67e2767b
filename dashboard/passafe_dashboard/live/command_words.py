"""Words of the page for what becomes of the operator's command."""

from collections.abc import Mapping
from math import floor
from typing import Final

from passafe_protocol.messages import CommandState, FilterTick

_WORDS: Final[Mapping[str, str]] = {
    CommandState.NONE: "none has come yet",
    CommandState.COUNTS: "counts",
    CommandState.RELEASED: "the dead-man is released",
    CommandState.SILENT: "does not count: no newer one comes",
    CommandState.DELAYED: "does not count: too old when it arrives",
    CommandState.STOPPED: "does not count: emergency stop, or made before it was cleared",
}


def command_words(tick: FilterTick) -> str:
    """Return whether the operator's command counts at a tick, and otherwise why not, in words.

    The percentage of a ramp is rounded down, so that 100 % means all of it.
    """
    if tick.command_state == CommandState.RESUMES:
        return f"ramps in after a stale stretch: {floor(100 * tick.command_share)} % of it counts"
    return _WORDS.get(tick.command_state, "not reported")
