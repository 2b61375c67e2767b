"""Node: the state machine of a process, stepped by a driver."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

from passafe_protocol.messages import Message, Received
from passafe_protocol.topics import Topic

Outgoing: TypeAlias = tuple[Topic, Message | Callable[[], Message]]
"""Message to publish: the topic, and the message or a pure function that returns it. The function is called only if the
topic has a reader, so a lockstep loop that records nothing does not compute telemetry."""


class Node(Protocol):
    """Process of the system as a state machine: no clock, no socket, no sleep.

    Attributes:
        name: Name of the process: ``operator``, ``filter``, ``plant``, …
        subscribes: Topics whose messages ``step`` receives in its inbox.
    """

    name: str
    subscribes: tuple[Topic, ...]

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Advance to ``now_ns`` and return the messages to publish.

        Args:
            now_ns: Time at which this step was due, monotonic, ns: on a grid of whole periods, later than the previous
                step. The step may begin slightly later, so a message may have been received after it.
            inbox: Messages that left their links since the previous step, in order of arrival.
        """
        ...
