"""The links at one process: scheduled changes of their settings, and when their state is told.

Both drivers use it. It knows no clock: the time is an argument.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Final

from passafe_protocol.link_change import LinkChange
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkConfig, LinkSource, LinkState

STATE_PERIOD_NS: Final = 1_000_000_000
"""How often every link's state is told."""

_NS_PER_S: Final = 1e9

Sources = Callable[[MessageLink], tuple[LinkSource, ...]]
"""Which messages were put into a link."""


class LinkControl:
    """Changes the links at one process and tells their states: at the first step, once a second, at every change.

    Args:
        links: The links.
        changes: Changes planned, of these links and of others, which are passed over.
        sources: Tells which messages were put into a link.

    Attributes:
        due_ns: Nothing needs to be done before; the driver may look here first.
    """

    def __init__(self, links: Iterable[MessageLink], changes: Iterable[LinkChange], sources: Sources) -> None:
        self.due_ns = 0
        self._links = {link.name: link for link in links}
        planned = [change for change in changes if change.link in self._links]
        self._planned = sorted(planned, key=lambda change: change.at_s, reverse=True)  # the next one last
        self._sources = sources
        self._zero_ns: int | None = None
        self._tell_ns = 0
        self._triggers: dict[str, str] = {}

    def configure(self, header: Header, config: LinkConfig) -> None:
        """Do what a message asks for, if it is about a link of this process."""
        link = self._links.get(config.link)
        if link is not None:
            link.configure(header, config)
            self._triggers[link.name] = "requested"
            self.due_ns = 0

    def advance(self, now_ns: int) -> None:
        """Make the changes that are due; before the messages of a step are put in."""
        if self._zero_ns is None:
            self._zero_ns = self._tell_ns = now_ns
            self._triggers = dict.fromkeys(self._links, "start")
        while self._planned and self._at_ns(self._planned[-1]) <= now_ns:
            change = self._planned.pop()
            self._links[change.link].reconfigure(change.settings)
            self._triggers[change.link] = "scheduled"

    def due_states(self, now_ns: int) -> Sequence[LinkState]:
        """States that are to be told; after the messages of a step were put in."""
        if now_ns >= self._tell_ns:
            self._tell_ns = now_ns + STATE_PERIOD_NS
            self._triggers = dict.fromkeys(self._links, "period") | self._triggers
        triggers, self._triggers = self._triggers, {}
        self.due_ns = min([self._tell_ns, *map(self._at_ns, self._planned[-1:])])
        return [self._state(name, trigger) for name, trigger in triggers.items()]

    def last_states(self) -> Sequence[LinkState]:
        """States of all links at the end of the run."""
        return [self._state(name, "end") for name in self._links]

    def _at_ns(self, change: LinkChange) -> int:
        return (self._zero_ns or 0) + round(change.at_s * _NS_PER_S)

    def _state(self, name: str, trigger: str) -> LinkState:
        link = self._links[name]
        return link.state(trigger, self._sources(link))
