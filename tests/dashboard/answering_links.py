"""Links that answer a page as running processes do, in the loop of a test's run."""

from itertools import count

from closed_form import header
from passafe_dashboard.live.feed import Feed
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.message_link import MessageLink
from passafe_protocol.messages import Header, LinkConfig
from passafe_protocol.topics import LINKS

EPOCH = 77


class AnsweringLinks:
    """One link of each name; a request is answered by the next call of ``answer``.

    Attributes:
        silent: Set it to leave requests unanswered.
        requests: Requests so far.
    """

    def __init__(self, feed: Feed) -> None:
        self.links = {name: MessageLink(name, LinkSettings()) for name in LINKS}
        self.silent = False
        self.requests: list[LinkConfig] = []
        self._feed = feed
        self._waiting: list[tuple[Header, LinkConfig]] = []
        self._numbers = count()

    def request(self, config: LinkConfig, _now_ns: int) -> tuple[str, int, int]:
        """Take a request, as a publisher would."""
        number = len(self.requests)
        self.requests.append(config)
        self._waiting.append((Header("dashboard", EPOCH, number, 0, 0, 0, 0), config))
        return "dashboard", EPOCH, number

    def publish_states(self, now_ns: int, trigger: str = "period", *names: str) -> None:
        """Publish the states of links, all if none is named."""
        for name in names or LINKS:
            head = header(LINKS[name].reader, next(self._numbers), epoch=1)
            self._feed.push(head, self.links[name].state(trigger, ()), now_ns)

    def answer(self, now_ns: int) -> None:
        """Answer the requests since the last call."""
        if self.silent:
            return
        waiting, self._waiting = self._waiting, []
        for head, config in waiting:
            self.links[config.link].configure(head, config)
            self.publish_states(now_ns, "requested", config.link)
