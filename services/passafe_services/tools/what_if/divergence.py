"""First message in which a re-run differs from its log, and the change that explains it."""

from collections import deque
from collections.abc import Sequence
from typing import Final

from msgspec.structs import astuple, replace
from passafe_protocol.field_difference import FieldDifference, are_identical, field_differences
from passafe_protocol.messages import (
    Consumed,
    FilterTick,
    Header,
    Message,
    OperatorCommand,
    PlantInput,
    PlantState,
)
from passafe_protocol.topics import STATE, TICK, TOPIC_OF_BODY, Topic
from pydantic import BaseModel, ConfigDict

from passafe_services.tools.review.run_log import RunLog
from passafe_services.tools.review.trajectory import NS_PER_S
from passafe_services.tools.what_if.arrivals import places
from passafe_services.tools.what_if.causes import Causes
from passafe_services.tools.what_if.route import Place

COMPARED: Final = (OperatorCommand, PlantState, FilterTick, PlantInput)
"""Messages that are compared: those of the loop."""

NAMED: Final = 3
"""Fields or messages that the text of a difference names."""

_LABELS: Final = frozenset({"mode", "law"})
"""Fields of a tick that name a setting: they differ from the first tick on and say nothing of what happened."""


class FirstDifference(BaseModel):
    """First message that differs.

    Attributes:
        at_s: Time since the plant's first step, s.
        plant_s: Plant time of the newest state before it, s.
        message: The message: its topic, with the number of the tick or message.
        fields: The fields that differ: logged value and new one; empty for a message that only one of the two has.
        text: The difference in words.
        cause: The change that explains it, in words.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    at_s: float
    plant_s: float
    message: str
    fields: tuple[str, ...]
    text: str
    cause: str


class DivergenceWatch:
    """Observer of a re-run that compares its messages with those of the log.

    Attributes:
        compared: Messages compared, by topic.
        identical: Those that are the same to the last bit.
        first: First difference of any message.
        first_motion: First state of the plant whose x differs.
    """

    def __init__(self, log: RunLog, causes: Causes) -> None:
        """Start before the first message.

        Args:
            log: The log.
            causes: What was changed.
        """
        self.compared = {TOPIC_OF_BODY[body].name: 0 for body in COMPARED}
        self.identical = dict(self.compared)
        self.first: FirstDifference | None = None
        self.first_motion: FirstDifference | None = None
        self._causes = causes
        self._logged = {TOPIC_OF_BODY[body].name: _LoggedMessages(log, body) for body in COMPARED}
        states = log.of(PlantState)
        self._start_ns = states[0].header.started_ns if states else 0
        self._plant_ns = 0
        self._last: dict[str, Place] = {}
        self._missing: Message | None = None

    @property
    def only_in_log(self) -> dict[str, int]:
        """Messages of the log that the re-run has not sent, by topic."""
        return {name: logged.left for name, logged in self._logged.items()}

    @property
    def is_exact(self) -> bool:
        """Return whether every tick and state was sent again, and is the same to the last bit."""
        return all(self.identical[t] == self.compared[t] and not self.only_in_log[t] for t in (STATE.name, TICK.name))

    def __call__(self, topic: Topic, header: Header, body: Message) -> None:
        """Compare a message of the re-run."""
        logged = self._logged.get(topic.name)
        if logged is None:
            return
        if self.first is None:
            for name, others in self._logged.items():
                missing = others.before(header.started_ns)
                if missing is not None:
                    started_ns, self._missing = missing
                    at_its_time = replace(header, started_ns=started_ns)
                    self.first = self._difference(name, at_its_time, self._missing, None)
                    break
        self._note_late(header, body)
        place = self._place(topic.name, header)
        before = logged.pop(place)
        self.compared[topic.name] += 1
        if before is not None and are_identical(before, body):
            self.identical[topic.name] += 1
        elif self.first is None and not _differ_in_order_only(before, body):
            self.first = self._difference(topic.name, header, before, body)
        if isinstance(body, PlantState):
            self._plant_ns = body.plant_ns
            if self.first_motion is None and isinstance(before, PlantState) and before.x != body.x:
                self.first_motion = self._difference(topic.name, header, before, body, only="x[")

    def _note_late(self, header: Header, body: Message) -> None:
        """Add to the first difference, a tick that was not sent in time, when it is sent after all."""
        missing = self._missing
        if not isinstance(missing, FilterTick) or not isinstance(body, FilterTick) or body.tick != missing.tick:
            return
        self._missing = None
        if self.first is not None:
            late_s = (header.started_ns - self._start_ns) / NS_PER_S - self.first.at_s
            age = _age("state", missing.state_age_ns, body.state_age_ns)
            text = f"tick {body.tick}: sent {late_s:.3f} s later" + (f", {age}" if age else "")
            self.first = self.first.model_copy(update={"text": text})

    def _place(self, topic: str, header: Header) -> Place:
        last = self._last.get(topic)
        is_same_step = last is not None and (last.epoch, last.scheduled_ns) == (header.epoch, header.scheduled_ns)
        number = last.number + 1 if last is not None and is_same_step else 0
        place = self._last[topic] = Place(header.epoch, header.scheduled_ns, number)
        return place

    def _difference(
        self, topic: str, header: Header, before: Message | None, after: Message | None, *, only: str = ""
    ) -> FirstDifference:
        fields = [] if before is None or after is None else field_differences(before, after)
        fields = [each for each in fields if each.path.startswith(only)]
        found = after if before is None else before
        number = f"tick {found.tick}" if isinstance(found, FilterTick) else f"{topic} {header.sequence}"
        if isinstance(found, PlantInput):
            number = f"input of tick {found.tick}"
        return FirstDifference(
            at_s=max(header.started_ns - self._start_ns, 0) / NS_PER_S,
            plant_s=self._plant_ns / NS_PER_S,
            message=number,
            fields=tuple(str(each) for each in fields),
            text=f"{number}: {_words(before, after, fields)}",
            cause=self._causes.of(topic, before, after, fields),
        )


class _LoggedMessages:
    """Messages of one topic in the log, by place, which are taken out as the re-run sends them."""

    def __init__(self, log: RunLog, body: type[Message]) -> None:
        messages = log.of(body)
        self._bodies: dict[Place, tuple[int, Message]] = {
            place: (message.header.started_ns, message.body)
            for place, message in zip(places(each.header for each in messages), messages, strict=True)
        }
        self._order = deque(sorted(self._bodies, key=lambda place: self._bodies[place][0]))

    @property
    def left(self) -> int:
        """Messages that were not taken out."""
        return len(self._bodies)

    def pop(self, place: Place) -> Message | None:
        """Take out the message of a place; ``None`` if the log has none."""
        found = self._bodies.pop(place, None)
        return None if found is None else found[1]

    def before(self, started_ns: int) -> tuple[int, Message] | None:
        """Return the first message of a step that began earlier, and when it began, ns; if one is left."""
        while self._order and self._order[0] not in self._bodies:
            self._order.popleft()
        if not self._order:
            return None
        first = self._bodies[self._order[0]]
        return first if first[0] < started_ns else None


def _differ_in_order_only(before: Message | None, after: Message) -> bool:
    """Return whether two ticks received the same, in another order: one without effect, as all else is the same."""
    if not isinstance(before, FilterTick) or not isinstance(after, FilterTick):
        return False
    is_same = sorted(map(astuple, before.consumed)) == sorted(map(astuple, after.consumed))
    return is_same and are_identical(replace(before, consumed=after.consumed), after)


def _words(before: Message | None, after: Message | None, fields: Sequence[FieldDifference]) -> str:
    """Return the difference in words: ages and arrivals before bare fields."""
    if after is None:
        return "not sent"
    if before is None:
        return "sent, which the log does not have"
    if isinstance(before, FilterTick) and isinstance(after, FilterTick):
        found = _age("state", before.state_age_ns, after.state_age_ns) or _age(
            "command", before.command_age_ns, after.command_age_ns
        )
        if found:
            return found
        if before.consumed != after.consumed:
            return f"it received {_received(after.consumed)} instead of {_received(before.consumed)}"
    shown = [each for each in fields if each.path not in _LABELS] or fields
    return ", ".join(str(each) for each in shown[:NAMED])


def _age(what: str, before_ns: int, after_ns: int) -> str:
    if before_ns == after_ns:
        return ""
    ages = ["unknown" if age < 0 else f"{age / NS_PER_S:.6g} s" for age in (after_ns, before_ns)]
    return f"age of {what} {ages[0]} instead of {ages[1]}"


def _received(consumed: Sequence[Consumed]) -> str:
    return ", ".join(f"{each.topic} {each.sequence}" for each in consumed[:NAMED]) or "nothing"
