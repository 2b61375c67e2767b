"""Causes of a difference: the changes that act on the message that differs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from passafe_protocol.field_difference import FieldDifference
from passafe_protocol.messages import FilterTick, Message
from passafe_protocol.topics import COMMAND, INPUT, STATE, TICK

from passafe_services.tools.what_if.changes import Change
from passafe_services.tools.what_if.recorded_steps import FILTER, PLANT

UNEXPLAINED: Final = "no change explains it: the log does not show all that the re-run needs"

_ARRIVAL_FIELDS: Final = frozenset(
    {"input_lead_ns", "inputs_late", "inputs_refused", "received_tick", "input_transit_ns", "input_epoch"}
)
"""Fields of a state that tell of the arrival of inputs."""

_OF_BOTH: Final = ("plant.", "rate_hz", "duration_s", "filter.prediction")
"""Beginnings of keys that act on plant and filter."""


@dataclass(frozen=True, kw_only=True)
class Causes:
    """Changes of a re-run.

    Attributes:
        changes: Keys of the scenario.
        operator: Who drives instead of the recorded commands; empty: nobody.
        links: How links differ without a changed key; empty: not at all.
    """

    changes: Sequence[Change]
    operator: str = ""
    links: str = ""

    def of(self, topic: str, before: Message | None, after: Message | None, fields: Sequence[FieldDifference]) -> str:
        """Return the changes that explain why a message is the first to differ, in words.

        Args:
            topic: Its topic.
            before: Its body in the log, if it has one.
            after: Its body in the re-run, if there is one.
            fields: The fields that differ.
        """
        found = list(dict.fromkeys(self._found(topic, before, after, fields)))
        return "; ".join(found) or UNEXPLAINED

    def _found(
        self, topic: str, before: Message | None, after: Message | None, fields: Sequence[FieldDifference]
    ) -> Iterator[str]:
        if topic == COMMAND.name:
            yield from self._operator()
        elif topic in {TICK.name, INPUT.name}:
            if isinstance(before, FilterTick) and isinstance(after, FilterTick):
                yield from self._of_filter(before, after)
            else:
                yield from self._on_links((STATE.links[FILTER], COMMAND.links[FILTER]))
                yield from self._on(FILTER)
        elif any(each.path in _ARRIVAL_FIELDS for each in fields):
            yield from self._on_links((INPUT.links[PLANT],))
            yield from self._on(PLANT)
        else:
            yield from self._on(PLANT)
            yield from self._on_links((INPUT.links[PLANT],))

    def _of_filter(self, before: FilterTick, after: FilterTick) -> Iterator[str]:
        """Explain a tick: by what the filter received, else by the filter itself."""
        if before.consumed != after.consumed:
            topics = {each.topic for each in {*before.consumed} ^ {*after.consumed}}
            yield from self._on_links([t.links[FILTER] for t in (STATE, COMMAND) if t.name in topics])
            yield from self._operator()
        yield from self._on(FILTER)

    def _operator(self) -> Iterator[str]:
        if self.operator:
            yield f"operator: {self.operator}"
        yield from (str(change) for change in self.changes if change.key.startswith("operator.source"))

    def _on(self, process: str) -> Iterator[str]:
        """Yield the changes of plant or filter themselves."""
        own = ("filter.", "operator.") if process == FILTER else ()
        for change in self.changes:
            if change.key.startswith((*own, *_OF_BOTH)) and not change.key.startswith("operator.source"):
                yield str(change)

    def _on_links(self, names: Sequence[str]) -> Iterator[str]:
        """Yield the changes of these links."""
        for change in self.changes:
            for name in names:
                if change.key.startswith((f"links.{name}", "link_changes")):
                    yield f"link {name}: {change}"
        if self.links and names:
            yield f"links: {self.links}"
