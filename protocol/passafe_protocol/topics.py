"""The one table of topics: bus, codec, links, recorder, health, access control and docs derive from it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, NamedTuple

from passafe_protocol.messages import (
    Event,
    FilterTick,
    Health,
    LinkConfig,
    LinkEvent,
    LinkState,
    Message,
    OperatorCommand,
    PlantInput,
    PlantState,
    ScenarioInfo,
)

KEY_ROOT: Final = "passafe"


class Congestion(Enum):
    """What the publisher does when the network is slower than it is."""

    DROP = "drop"
    """Lose the sample: control traffic, where the next one is worth more than this one."""

    BLOCK = "block"
    """Wait: rare messages that must arrive."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Topic:
    """One row of the table.

    Attributes:
        name: Last chunk of the key expression, unique.
        body: Message type carried.
        publishers: Processes that may publish it.
        rate_hz: Nominal rate; ``None`` where it is the scenario's ``rate_hz``, 0 for on trigger.
        deadline_s: A reader calls the topic late when nothing arrived for that long; ``None``: never.
        congestion: What the publisher does on congestion.
        queue: Capacity of a reader's ring; the oldest is dropped when it is full.
        recorded: Whether the recorder logs it and its publishers keep a cache for it.
        links: Names of the injected links on its way, by the process at whose inlet each one sits.
    """

    name: str
    body: type[Message]
    publishers: tuple[str, ...]
    rate_hz: float | None
    deadline_s: float | None
    congestion: Congestion
    queue: int
    recorded: bool = True
    links: Mapping[str, str] = field(default_factory=dict)

    def key(self, source: str) -> str:
        """Key expression under which the process ``source`` publishes this topic."""
        return f"{KEY_ROOT}/{source}/{self.name}"

    @property
    def selector(self) -> str:
        """Key expression that a reader subscribes to: this topic of every publisher."""
        publisher = self.publishers[0] if len(self.publishers) == 1 else "*"
        return f"{KEY_ROOT}/{publisher}/{self.name}"


PROCESSES: Final = ("router", "recorder", "dashboard", "operator", "filter", "plant")
"""Every process of a running system, in the order in which a supervisor starts them: the plant last, since
the robot moves as soon as it is there, and so the first to be stopped."""

COMMAND: Final = Topic(
    name="command",
    body=OperatorCommand,
    publishers=("operator",),
    rate_hz=None,
    deadline_s=0.1,
    congestion=Congestion.DROP,
    queue=256,
    links={"filter": "operator-to-filter"},
)
INPUT: Final = Topic(
    name="input",
    body=PlantInput,
    publishers=("filter",),
    rate_hz=None,
    deadline_s=0.05,
    congestion=Congestion.DROP,
    queue=256,
    links={"plant": "filter-to-plant"},
)
STATE: Final = Topic(
    name="state",
    body=PlantState,
    publishers=("plant",),
    rate_hz=None,
    deadline_s=0.05,
    congestion=Congestion.DROP,
    queue=256,
    links={"filter": "plant-to-filter", "operator": "plant-to-operator"},
)
TICK: Final = Topic(
    name="tick",
    body=FilterTick,
    publishers=("filter",),
    rate_hz=None,
    deadline_s=0.05,
    congestion=Congestion.DROP,
    queue=256,
)
LINK_CONFIG: Final = Topic(
    name="link_config",
    body=LinkConfig,
    publishers=("dashboard", "console"),
    rate_hz=0.0,
    deadline_s=None,
    congestion=Congestion.BLOCK,
    queue=16,
)
LINK_EVENT: Final = Topic(
    name="link_event",
    body=LinkEvent,
    publishers=("operator", "filter", "plant"),
    rate_hz=0.0,
    deadline_s=None,
    congestion=Congestion.DROP,
    queue=1024,
)
LINK_STATE: Final = Topic(
    name="link_state",
    body=LinkState,
    publishers=("operator", "filter", "plant"),
    rate_hz=1.0,
    deadline_s=3.0,
    congestion=Congestion.BLOCK,
    queue=64,
)
HEALTH: Final = Topic(
    name="health",
    body=Health,
    publishers=PROCESSES,
    rate_hz=1.0,
    deadline_s=3.0,
    congestion=Congestion.DROP,
    queue=64,
)
EVENT: Final = Topic(
    name="event",
    body=Event,
    publishers=PROCESSES,
    rate_hz=0.0,
    deadline_s=None,
    congestion=Congestion.BLOCK,
    queue=64,
)
SCENARIO: Final = Topic(
    name="scenario",
    body=ScenarioInfo,
    publishers=("filter",),
    rate_hz=0.0,
    deadline_s=None,
    congestion=Congestion.BLOCK,
    queue=4,
)

TOPICS: Final = (COMMAND, INPUT, STATE, TICK, LINK_CONFIG, LINK_EVENT, LINK_STATE, HEALTH, EVENT, SCENARIO)
TOPIC_OF_NAME: Final = {topic.name: topic for topic in TOPICS}
TOPIC_OF_BODY: Final[dict[type[Message], Topic]] = {topic.body: topic for topic in TOPICS}


class LinkPlace(NamedTuple):
    """Where an injected link sits.

    Attributes:
        topic: Topic whose messages it carries.
        reader: Process at whose inlet it is.
    """

    topic: Topic
    reader: str


LINKS: Final = {name: LinkPlace(topic, reader) for topic in TOPICS for reader, name in topic.links.items()}
"""Every injected link by name."""
