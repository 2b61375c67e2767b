"""Check of the states of a link: each beside the one before, and beside the scenario."""

from collections import Counter
from collections.abc import Mapping
from typing import Final

from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of
from passafe_protocol.messages import LinkParameters, LinkState
from passafe_protocol.topics import LINKS

from passafe_services.scenarios.schema import Scenario

COUNTS: Final = (
    *("entered", "delivered", "dropped_loss", "dropped_queue", "dropped_outage", "duplicated", "corrupted"),
    *("refused_corrupted", "refused_duplicate"),
)
"""Counts of a link that never go back."""

START: Final = "start"
END: Final = "end"


class LinkStateCheck:
    """Check of the states of one link in one session of its reader, as they come.

    Args:
        name: The link.
        expected: Settings with which it starts; ``None`` if they are not known.

    Attributes:
        contradictions: What cannot be so, by kind.
    """

    def __init__(self, name: str, expected: LinkParameters | None) -> None:
        self.contradictions: Counter[str] = Counter()
        self._topic = LINKS[name].topic.name if name in LINKS else ""
        self._expected = expected
        self._before: LinkState | None = None
        self._epoch: int | None = None

    @property
    def found(self) -> dict[str, int]:
        """Numbers of what cannot be so, by kind; nothing that was not found."""
        return {what: number for what, number in self.contradictions.items() if number}

    def take(self, state: LinkState, epoch: int) -> None:
        """Take the next state.

        Args:
            state: The state.
            epoch: Session of the reader that published it; in lockstep, a link outlives its reader's session.
        """
        found, before = self.contradictions, self._before
        self._before = state
        self._epoch = epoch if self._epoch is None else self._epoch
        is_one_session = epoch == self._epoch  # what is in flight at a restart makes numbers jump, which are refused
        found["states of another topic"] += state.topic != self._topic
        found["refused messages that were neither corrupted nor copies"] += (
            state.refused_corrupted > state.corrupted or (is_one_session and state.refused_duplicate > state.duplicated)
        )
        requested = state.config_epoch or state.config_sequence or state.refusal
        found["requests of nobody"] += bool(requested and not state.config_source)
        has_trace = state.trace_opportunities > 0 and not state.config_source
        found["traces that the scenario does not have"] += has_trace and self._expected is not None
        found["states with settings of nobody"] += self._has_other_settings(state)
        if before is None:
            found["ends without a beginning"] += state.trigger == END
            return
        found["balance of a state"] += _imbalance(before) != 0  # that of the last one is in the account
        found["states after the end"] += before.trigger == END != state.trigger  # an end may be reported twice
        found["starts after the first state"] += state.trigger == START
        found["counts that go back"] += any(getattr(state, name) < getattr(before, name) for name in COUNTS)
        configured = (state.config_source, state.config_epoch, state.config_sequence, state.refusal)
        changed = configured != (before.config_source, before.config_epoch, before.config_sequence, before.refusal)
        found["requests that nobody reports"] += changed and state.trigger == "period"
        unasked = state.parameters != before.parameters and state.trigger in {"period", END}
        found["settings that change by themselves"] += unasked

    def _has_other_settings(self, state: LinkState) -> bool:
        known = self._expected is not None and state.trigger == START and not state.config_source
        return known and state.parameters != self._expected


def _imbalance(state: LinkState) -> int:
    dropped = state.dropped_loss + state.dropped_queue + state.dropped_outage
    return state.entered + state.duplicated - state.delivered - dropped - state.in_flight


def start_settings(scenario: Scenario) -> dict[str, LinkParameters | None]:
    """Return the settings with which each link starts, by its name; ``None`` for one with a recorded trace."""
    found: dict[str, LinkParameters | None] = {name: parameters_of(LinkSettings()) for name in LINKS}
    for name, config in scenario.links.items():
        found[name] = parameters_of(config.settings()) if config.trace is None else None
    return found


def count_differences(state: LinkState, dropped: Mapping[str, int], events: Counter[tuple[str, str]]) -> dict[str, int]:
    """Return the differences between the counts of the state and of the events."""
    counts = Counter(events)
    differences = {
        f"dropped by {cause}": abs(number - counts.pop(("dropped", cause), 0)) for cause, number in dropped.items()
    }
    differences["duplicated"] = abs(state.duplicated - counts.pop(("duplicated", ""), 0))
    differences["corrupted"] = abs(state.corrupted - counts.pop(("corrupted", ""), 0))
    differences["events of no known effect"] = sum(counts.values())
    return differences
