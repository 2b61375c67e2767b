"""Messages of a process about itself: health, events and the configuration of the run."""

from enum import StrEnum

from passafe_protocol.messages.record import Record


class TopicHealth(Record, frozen=True):
    """Message counts of one topic at one process since its start."""

    topic: str
    received: int
    gaps: int
    refused: int


class Health(Record, frozen=True):
    """Loop timing and message counts of a process, published once per second."""

    rate_hz: float
    steps: int
    overruns: int
    steps_skipped: int
    late_us_max: float
    topics: tuple[TopicHealth, ...]


class RecordedSession(Record, frozen=True):
    """Newest recorded message of one session of a publisher on one topic."""

    source: str
    topic: str
    epoch: int
    newest: int


class Receipt(Record, frozen=True):
    """Newest messages that the recorder has taken, published ten times per second."""

    sessions: tuple[RecordedSession, ...]


class EventKind(StrEnum):
    """Kind of an event that carries numbers, for programs."""

    TEXT = ""
    """None: the text says it all."""

    MODEL_VIOLATED = "MODEL_VIOLATED"
    """A plant state lies outside of what the scenario's sets allow from the ones before."""


class Event(Record, frozen=True):
    """Human-readable event; some kinds carry their numbers, too."""

    severity: str
    text: str
    kind: str = ""
    number: int = 0
    axis: str = ""
    factor: float = 0.0


class ScenarioInfo(Record, frozen=True):
    """Effective configuration of a run."""

    scenario_json: str
    driver: str
    versions_json: str
