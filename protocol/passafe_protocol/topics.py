"""Table of topics, from which bus, codec, links, recorder, health, access control and docs are derived."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Final, NamedTuple

from passafe_protocol.keys import DEFAULT_ROBOT, key_of
from passafe_protocol.messages import (
    EmergencyStop,
    Event,
    FilterTick,
    Health,
    LinkConfig,
    LinkEvent,
    LinkState,
    Message,
    OperatorCommand,
    OperatorLease,
    PlantInput,
    PlantState,
    Receipt,
    ScenarioInfo,
    Steer,
    StopClear,
)


class Congestion(Enum):
    """Behaviour of a publisher on congestion."""

    DROP = "drop"
    """Drop the sample: control traffic, where the next sample supersedes it."""

    BLOCK = "block"
    """Wait: rare messages that must arrive."""


class Priority(Enum):
    """Priority of a topic's messages: each has queues of its own, from publisher to reader."""

    REAL_TIME = "real-time"
    """The emergency stop alone: nothing waits before it."""

    DATA = "data"
    """Everything else."""


@dataclass(frozen=True, kw_only=True, slots=True, eq=False)
class Topic:
    """One row of the table.

    Attributes:
        name: Last chunk of the key expression, unique.
        body: Message type.
        publishers: Processes that may publish it.
        rate_hz: Nominal rate; ``None``: the scenario's ``rate_hz``; 0: occasional.
        deadline_s: Time without a message after which a reader reports the topic as late; ``None``: never.
        congestion: Behaviour on congestion.
        priority: Priority of its messages.
        any_session: Whether a reader's inlet admits every session of a publisher side by side, and the node decides
            which counts; otherwise one session at a time is admitted.
        queue: Capacity of a reader's ring; the oldest message is dropped when it is full.
        recorded: Whether the recorder logs it and its publishers keep a cache for the recorder.
        links: Names of the injected links on its route, by reading process.
    """

    name: str
    body: type[Message]
    publishers: tuple[str, ...]
    queue: int
    rate_hz: float | None = None
    deadline_s: float | None = None
    congestion: Congestion = Congestion.DROP
    priority: Priority = Priority.DATA
    any_session: bool = False
    recorded: bool = True
    links: Mapping[str, str] = field(default_factory=dict)

    def key(self, source: str, robot: str = DEFAULT_ROBOT) -> str:
        """Return the key expression under which the process ``source`` of a robot publishes this topic."""
        return key_of(robot, source, self.name)

    def selector(self, robot: str = DEFAULT_ROBOT) -> str:
        """Return the key expression that a reader subscribes to: this topic of every publisher of a robot."""
        return key_of(robot, self.publishers[0] if len(self.publishers) == 1 else "*", self.name)


PROCESSES: Final = ("router", "recorder", "dashboard", "operator", "filter", "plant")
"""Processes of a running system in the order in which the supervisor starts them: the plant last, because the robot
moves as soon as it runs; it is stopped first."""

READERS: Final = ("bridge",)
"""Processes that read a robot's topics and publish none."""

STOP: Final = Topic(
    name="stop",
    body=EmergencyStop,
    publishers=("operator", "dashboard", "console"),
    rate_hz=0.0,
    priority=Priority.REAL_TIME,
    any_session=True,
    queue=256,
)
"""Without an injected link: who may change links must not be able to delay a stop."""

CLEAR: Final = Topic(
    name="clear",
    body=StopClear,
    publishers=("dashboard", "console"),
    rate_hz=0.0,
    any_session=True,
    queue=16,
)
STEER: Final = Topic(name="steer", body=Steer, publishers=("dashboard",), rate_hz=0.0, queue=64)
COMMAND: Final = Topic(
    name="command",
    body=OperatorCommand,
    publishers=("operator",),
    deadline_s=0.1,
    any_session=True,
    queue=256,
    links={"filter": "operator-to-filter"},
)
INPUT: Final = Topic(
    name="input",
    body=PlantInput,
    publishers=("filter",),
    deadline_s=0.05,
    queue=256,
    links={"plant": "filter-to-plant"},
)
STATE: Final = Topic(
    name="state",
    body=PlantState,
    publishers=("plant",),
    deadline_s=0.05,
    queue=256,
    links={"filter": "plant-to-filter", "operator": "plant-to-operator"},
)
LEASE: Final = Topic(name="lease", body=OperatorLease, publishers=("filter",), rate_hz=5.0, deadline_s=1.0, queue=16)
TICK: Final = Topic(name="tick", body=FilterTick, publishers=("filter",), deadline_s=0.05, queue=256)
LINK_CONFIG: Final = Topic(
    name="link_config",
    body=LinkConfig,
    publishers=("dashboard", "console"),
    rate_hz=0.0,
    congestion=Congestion.BLOCK,
    any_session=True,
    queue=16,
)
LINK_EVENT: Final = Topic(
    name="link_event", body=LinkEvent, publishers=("operator", "filter", "plant"), rate_hz=0.0, queue=1024
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
HEALTH: Final = Topic(name="health", body=Health, publishers=PROCESSES, rate_hz=1.0, deadline_s=3.0, queue=64)
RECEIPT: Final = Topic(
    name="receipt", body=Receipt, publishers=("recorder",), rate_hz=10.0, deadline_s=3.0, queue=1, recorded=False
)
EVENT: Final = Topic(name="event", body=Event, publishers=PROCESSES, rate_hz=0.0, congestion=Congestion.BLOCK, queue=64)
SCENARIO: Final = Topic(
    name="scenario", body=ScenarioInfo, publishers=("filter",), rate_hz=0.0, congestion=Congestion.BLOCK, queue=4
)

TOPICS: Final = (
    STOP,
    CLEAR,
    STEER,
    COMMAND,
    LEASE,
    INPUT,
    STATE,
    TICK,
    LINK_CONFIG,
    LINK_EVENT,
    LINK_STATE,
    HEALTH,
    RECEIPT,
    EVENT,
    SCENARIO,
)
TOPIC_OF_NAME: Final = {topic.name: topic for topic in TOPICS}
TOPIC_OF_BODY: Final[dict[type[Message], Topic]] = {topic.body: topic for topic in TOPICS}


class LinkLocation(NamedTuple):
    """Topic and reader of an injected link.

    Attributes:
        topic: Topic whose messages it carries.
        reader: Process that reads it.
    """

    topic: Topic
    reader: str


LINKS: Final = {name: LinkLocation(topic, reader) for topic in TOPICS for reader, name in topic.links.items()}
"""Every injected link by name."""
