"""Scenario that all processes of a system share: repeated by the filter, compared by every other one."""

import json
from hashlib import sha256
from typing import Final

from passafe_protocol.codec import decode
from passafe_protocol.errors import ProtocolError
from passafe_protocol.messages import Message, ScenarioInfo
from passafe_protocol.topics import SCENARIO

from passafe_services.loop.bus import Bus, TopicReader

DIGITS: Final = 8
"""Hexadecimal digits of a digest that are shown."""


class SharedScenario:
    """Scenario of one process beside that of the filter; both methods are called once a second.

    Args:
        process: The process.
        scenario_json: Its scenario, as the filter would publish it; empty: nothing is compared.
        bus: The session.
    """

    def __init__(self, process: str, scenario_json: str, bus: Bus) -> None:
        self._process = process
        self._own = scenario_json
        self._published: ScenarioInfo | None = None
        compares = scenario_json and process not in SCENARIO.publishers
        self._reader: TopicReader | None = bus.reader(SCENARIO) if compares else None

    def keep(self, body: Message) -> None:
        """Keep what this process published, to repeat it."""
        if isinstance(body, ScenarioInfo):
            self._published = body

    @property
    def repeated(self) -> ScenarioInfo | None:
        """Scenario to publish once more, for those that came later; ``None`` if this process publishes none."""
        return self._published

    def difference(self) -> str:
        """Return in words how the filter's scenario differs from the own one; empty if it does not, as far as known."""
        received = self._reader.drain() if self._reader is not None else []
        if not received:
            return ""
        try:
            _, info = decode(SCENARIO, received[-1])
        except ProtocolError:  # counted by those that use it
            return ""
        if not isinstance(info, ScenarioInfo) or info.scenario_json == self._own:
            return ""
        filters, own = (f"{_rate(text)}, digest {digest(text)}" for text in (info.scenario_json, self._own))
        return (
            f"scenario digests differ: the filter's ({filters}), the {self._process}'s ({own}): give all the same file"
        )


def digest(scenario_json: str) -> str:
    """Return the first digits of a scenario's digest."""
    return sha256(scenario_json.encode()).hexdigest()[:DIGITS]


def _rate(scenario_json: str) -> str:
    try:
        return f"{json.loads(scenario_json)['rate_hz']:g} Hz"
    except (ValueError, KeyError, TypeError):
        return "unknown rate"
