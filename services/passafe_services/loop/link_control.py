"""Controls the links at one process: applies changes of settings and reports link states.

Both drivers use it. The time is an argument; it has no clock.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Final

from passafe_protocol.link_change import LinkChange
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkConfig, LinkSource, LinkState

STATE_PERIOD_NS: Final = 1_000_000_000
"""Period of the state reports."""

_NS_PER_S: Final = 1e9

SourcesOf = Callable[[MessageLink], tuple[LinkSource, ...]]
"""Returns the messages that entered a link, by sender and session."""


class LinkControl:
    """Changes the links at one process and reports their states: at the first step, once a second, at every change.

    Args:
        links: The links.
        changes: Scheduled changes of these links; those of other links are ignored.
        sources: Returns the messages that entered a link.

    Attributes:
        due_ns: Time of the next change or report; nothing happens before.
    """

    def __init__(self, links: Iterable[MessageLink], changes: Iterable[LinkChange], sources: SourcesOf) -> None:
        self.due_ns = 0
        self._links = {link.name: link for link in links}
        scheduled = [change for change in changes if change.link in self._links]
        self._scheduled = sorted(scheduled, key=lambda change: change.at_s, reverse=True)  # the next one last
        self._sources = sources
        self._zero_ns: int | None = None
        self._report_ns = 0
        self._triggers: dict[str, str] = {}

    def configure(self, header: Header, config: LinkConfig) -> None:
        """Apply a requested configuration if it concerns a link of this process."""
        link = self._links.get(config.link)
        if link is not None:
            link.configure(header, config)
            self._triggers[link.name] = "requested"
            self.due_ns = 0

    def advance(self, now_ns: int) -> None:
        """Apply the changes that are due; called before the messages of a step are put in."""
        if self._zero_ns is None:
            self._zero_ns = self._report_ns = now_ns
            self._triggers = dict.fromkeys(self._links, "start")
        while self._scheduled and self._at_ns(self._scheduled[-1]) <= now_ns:
            change = self._scheduled.pop()
            self._links[change.link].reconfigure(change.settings)
            self._triggers[change.link] = "scheduled"

    def due_states(self, now_ns: int) -> Sequence[LinkState]:
        """Return the states to report; called after the messages of a step were put in."""
        if now_ns >= self._report_ns:
            self._report_ns = now_ns + STATE_PERIOD_NS
            self._triggers = dict.fromkeys(self._links, "period") | self._triggers
        triggers, self._triggers = self._triggers, {}
        self.due_ns = min([self._report_ns, *map(self._at_ns, self._scheduled[-1:])])
        return [self._state(name, trigger) for name, trigger in triggers.items()]

    def last_states(self) -> Sequence[LinkState]:
        """Return the states of all links at the end of the run."""
        return [self._state(name, "end") for name in self._links]

    def _at_ns(self, change: LinkChange) -> int:
        return (self._zero_ns or 0) + round(change.at_s * _NS_PER_S)

    def _state(self, name: str, trigger: str) -> LinkState:
        link = self._links[name]
        return link.state(trigger, self._sources(link))
