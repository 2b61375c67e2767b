"""What a node is: a pure state machine that a driver steps."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeAlias

from passafe_protocol.messages import Message, Received
from passafe_protocol.topics import Topic

Outgoing: TypeAlias = tuple[Topic, Message | Callable[[], Message]]
"""A message to publish: the topic, and the message or a function without side effects that makes it. The function is
called only if somebody reads the topic, so a lockstep loop that records nothing does not pay for telemetry."""


class Node(Protocol):
    """A process of the system as a state machine: no clock, no socket, no sleep.

    Attributes:
        name: The process's name: ``operator``, ``filter``, ``plant``, …
        subscribes: Topics whose messages ``step`` wants in its inbox.
    """

    name: str
    subscribes: tuple[Topic, ...]

    def step(self, now_ns: int, inbox: Sequence[Received]) -> Sequence[Outgoing]:
        """Advance to ``now_ns`` and return what is to be published.

        Args:
            now_ns: When this step was due, monotonic, ns: on a grid of whole periods, later than the step before. It
                may have begun a little later, so a message may have been received after it.
            inbox: Messages that came out of their links since the step before, in order of arrival.
        """
        ...
