"""Reads the bus and turns its messages into those of viewers."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final, Protocol

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import ScenarioInfo
from passafe_protocol.topics import TOPICS, Topic
from pydantic import ValidationError

from passafe_services.scenarios.schema import Scenario
from passafe_services.tables.layout import TableLayout
from passafe_services.tables.log_messages import LoggedRow
from passafe_services.viewer.run_view import RunView
from passafe_services.viewer.view_message import ViewMessage

POLL_HZ: Final = 50.0
MOST_AT_ONCE: Final = 2
"""Messages of a topic at the scenario's rate that are shown at each poll, the newest: 100 a second."""

QUEUE: Final = 4096


class PayloadSource(Protocol):
    """Reader of a topic, such as ``TopicReader``."""

    def drain(self) -> list[bytes]:
        """Return the payloads received since the last call."""
        ...


class OpenBus(Protocol):
    """Bus, as far as the bridge needs it."""

    def reader(self, topic: Topic) -> PayloadSource:
        """Return a reader of a topic."""
        ...


class BusView:
    """View of the robot behind a bus; it publishes nothing.

    Args:
        bus: The session.
        scenario: Scenario until the filter names its own.
    """

    def __init__(self, bus: OpenBus, scenario: Scenario) -> None:
        self._readers = [(topic, bus.reader(replace(topic, queue=QUEUE))) for topic in TOPICS]
        self._layouts = {topic.name: TableLayout(topic) for topic in TOPICS}
        self._start_ns: int | None = None
        self._scenario = scenario
        self._view: RunView | None = None
        self.refused = 0
        """Messages that do not decode."""

    def poll(self) -> Iterator[ViewMessage]:
        """Yield what has arrived since the last call, as viewers show it."""
        for topic, reader in self._readers:
            arrived = reader.drain()
            if topic.rate_hz is None:
                del arrived[:-MOST_AT_ONCE]
            for data in arrived:
                yield from self._views(topic, data)

    def _views(self, topic: Topic, data: bytes) -> Iterator[ViewMessage]:
        try:
            header, body = decode(topic, data)
        except ProtocolError:
            self.refused += 1
            return
        if self._start_ns is None:
            self._start_ns = header.wall_ns
        if isinstance(body, ScenarioInfo):
            self._take_scenario(body.scenario_json)
        if self._view is None:
            self._view = RunView(self._scenario, self._layouts, self._start_ns)
        self._layouts[topic.name].note(body)
        yield from self._view.views(LoggedRow(topic, topic.key(header.source), header.wall_ns, header, body, data))

    def _take_scenario(self, text: str) -> None:
        """Show the scene of another scenario from now on; one that this version cannot read is passed over."""
        try:
            scenario = Scenario.model_validate_json(text)
        except ValidationError:
            return
        if scenario != self._scenario:
            self._scenario, self._view = scenario, None
