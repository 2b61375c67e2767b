"""A message for a viewer: where it is shown, what it is, and its bytes."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.timestamp_pb2 import Timestamp

from passafe_services.viewer.schemas import descriptor_set

_NS_PER_S = 1_000_000_000


@dataclass(frozen=True, kw_only=True, eq=False)
class ViewTopic:
    """A topic of a viewer.

    Attributes:
        name: Its name, with a slash in front as viewers have it.
        message_type: Protobuf message type of its messages.
    """

    name: str
    message_type: type[ProtobufMessage]

    @property
    def schema_name(self) -> str:
        """Full name of the message type."""
        return self.message_type.DESCRIPTOR.full_name

    @cached_property
    def schema(self) -> bytes:
        """Schema as a serialized ``FileDescriptorSet``."""
        return descriptor_set(self.message_type)


class ViewMessage(NamedTuple):
    """One message of a viewer's topic.

    Attributes:
        topic: The topic.
        message: The message.
        time_ns: Its time, Unix time, ns.
    """

    topic: ViewTopic
    message: ProtobufMessage
    time_ns: int


def timestamp(time_ns: int) -> Any:  # noqa: ANN401 - a class that protobuf makes at run time
    """Return a protobuf time."""
    return Timestamp(seconds=time_ns // _NS_PER_S, nanos=time_ns % _NS_PER_S)
