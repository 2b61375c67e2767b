"""Settings of a link outlive the session of its reader."""

from typing import Any

import pytest
from msgspec import structs
from passafe_dashboard.live.link_keeper import REPEAT_NS, LinkKeeper
from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of
from passafe_protocol.messages import Header, LinkConfig, LinkParameters, LinkState
from passafe_services.loop.link_states import NewestLinkStates

LINK, READER = "plant-to-filter", "filter"
IDEAL, SLOW, SLOWER = (parameters_of(LinkSettings(delay_s=delay_s)) for delay_s in (0.0, 0.25, 0.5))
PAUSE_NS = 5_000_000_000
"""Time between two sessions of a reader: a stranger could pretend to be the next one while the last still sends."""


class Links:
    """A link with its keeper, and what the keeper did."""

    def __init__(self) -> None:
        self.board = NewestLinkStates()
        self.requests: list[LinkConfig] = []
        self.reports: list[str] = []
        self.now_ns = 0
        self._keeper = LinkKeeper(
            self.board,
            lambda config, _now_ns: self.requests.append(config),
            lambda text, _now_ns: self.reports.append(text),
        )
        self._session = 0
        self._sequence = 0

    def state(self, parameters: LinkParameters, *, session: int, source: str = "", refusal: str = "") -> None:
        """Receive a state of the link, and let the keeper look."""
        zero: dict[str, Any] = dict.fromkeys(LinkState.__struct_fields__, 0)
        state = structs.replace(
            LinkState(**zero),
            link=LINK,
            topic="state",
            parameters=parameters,
            trigger="period",
            config_source=source,
            refusal=refusal,
            sources=(),
        )
        if session != self._session:
            self._session, self._sequence = session, 0
            self.now_ns += PAUSE_NS
        self._sequence += 1
        self.now_ns += REPEAT_NS // 2
        header = Header(READER, session, self._sequence, self.now_ns, self.now_ns, self.now_ns, 0)
        self.board.receive(header, state, self.now_ns)
        self._keeper.step(self.now_ns)


@pytest.fixture
def links() -> Links:
    return Links()


def test_new_session_of_the_reader_is_asked_for_what_was_set(links: Links) -> None:
    links.state(IDEAL, session=1)
    links.state(SLOW, session=1, source="dashboard")
    assert links.requests == []

    links.state(IDEAL, session=2)
    assert links.requests == [LinkConfig(LINK, SLOW)]
    assert links.reports == [
        "plant-to-filter: filter has started anew: the settings that were requested before are set again"
    ]

    links.state(SLOW, session=2, source="dashboard")
    links.state(IDEAL, session=3)
    assert links.requests == [LinkConfig(LINK, SLOW)] * 2


def test_request_is_repeated_until_it_has_an_effect(links: Links) -> None:
    links.state(SLOW, session=1, source="dashboard")
    for _ in range(5):  # half a second each
        links.state(IDEAL, session=2)

    assert len(links.requests) == 3


def test_newest_request_counts_whoever_made_it(links: Links) -> None:
    links.state(SLOW, session=1, source="dashboard")
    links.state(SLOWER, session=1, source="link-console")
    links.state(IDEAL, session=2)

    assert links.requests == [LinkConfig(LINK, SLOWER)]


def test_link_that_nobody_changed_is_left_alone(links: Links) -> None:
    links.state(SLOW, session=1)  # as its scenario says
    links.state(IDEAL, session=2)

    assert links.requests == []


def test_refused_settings_are_not_asked_for_again(links: Links) -> None:
    links.state(SLOW, session=1, source="dashboard")
    links.state(SLOWER, session=1, source="dashboard", refusal="too slow")
    links.state(IDEAL, session=2)

    assert links.requests == [LinkConfig(LINK, SLOW)]


def test_session_that_has_the_settings_already_is_left_alone(links: Links) -> None:
    links.state(SLOW, session=1, source="dashboard")
    links.state(SLOW, session=2)

    assert links.requests == []
