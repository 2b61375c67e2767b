"""Fields of a topic's messages as columns of a table, by path: ``header.sequence``, ``x``, ``rows.dual``."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from passafe_protocol import passafe_pb2
from passafe_protocol.messages import Header, Message
from passafe_protocol.topics import Topic

_DTYPE = {
    FieldDescriptor.TYPE_DOUBLE: np.dtype(np.float64),
    FieldDescriptor.TYPE_SFIXED64: np.dtype(np.int64),
    FieldDescriptor.TYPE_FIXED64: np.dtype(np.uint64),
    FieldDescriptor.TYPE_UINT64: np.dtype(np.uint64),
    FieldDescriptor.TYPE_UINT32: np.dtype(np.uint64),
    FieldDescriptor.TYPE_BOOL: np.dtype(np.bool_),
    FieldDescriptor.TYPE_ENUM: np.dtype(np.int64),
    FieldDescriptor.TYPE_STRING: np.dtype(np.int32),  # codes of ``Texts``
}
LENGTH = "length"
"""Last part of the path of a list's or vector's length: ``barriers.length``, ``barriers.psi.length``."""

_LEFT_OUT = frozenset({"checksum", "header.schema_version"})


@dataclass(frozen=True, kw_only=True, slots=True)
class MessageField:
    """Field of a topic's messages, which makes a column.

    Attributes:
        path: Its path.
        dtype: Type of its numbers.
        is_text: Whether it holds texts.
        steps: Names on the path.
        is_ragged: Whether a message holds a varying number of values: a vector, or a field within a list.
        is_length: Whether it is the length of a list or vector.
    """

    path: str
    dtype: np.dtype[Any]
    is_text: bool
    steps: tuple[str, ...]
    is_ragged: bool
    is_length: bool = False

    def values(self, header: Header, body: Message) -> list[Any]:
        """Return the values of one message, one behind the other; one only of a field that is not ragged."""
        steps = self.steps
        start: object = body
        if steps[0] == "header":
            start, steps = header, steps[1:]
        return list(_walk(start, steps, is_length=self.is_length))


def _walk(value: Any, steps: tuple[str, ...], *, is_length: bool) -> Iterator[Any]:  # noqa: ANN401 - any record
    if not steps:
        if is_length:
            yield len(value)
        elif isinstance(value, tuple):
            yield from value
        else:
            yield value
        return
    inner = getattr(value, steps[0])
    if isinstance(inner, tuple) and len(steps) > 1:
        for element in inner:
            yield from _walk(element, steps[1:], is_length=is_length)
    else:
        yield from _walk(inner, steps[1:], is_length=is_length)


def descriptor_of(topic: Topic) -> Descriptor:
    """Return the protobuf type of a topic's messages."""
    descriptor: Descriptor = getattr(passafe_pb2, topic.body.__name__).DESCRIPTOR
    return descriptor


@cache
def fields_of(topic: Topic) -> Mapping[str, MessageField]:
    """Return every field of a topic's messages by path, those of the header included."""
    return {field.path: field for field in _fields(descriptor_of(topic), (), is_ragged=False)}


def _fields(descriptor: Any, steps: tuple[str, ...], *, is_ragged: bool) -> Iterator[MessageField]:  # noqa: ANN401 - protobuf types it as optional
    for field in descriptor.fields:
        on_path = (*steps, field.name)
        path = ".".join(on_path)
        if path in _LEFT_OUT:
            continue
        if field.is_repeated:
            yield MessageField(
                path=f"{path}.{LENGTH}",
                dtype=np.dtype(np.int64),
                is_text=False,
                steps=on_path,
                is_ragged=is_ragged,
                is_length=True,
            )
        if field.type == FieldDescriptor.TYPE_MESSAGE:
            yield from _fields(field.message_type, on_path, is_ragged=is_ragged or field.is_repeated)
        else:
            yield MessageField(
                path=path,
                dtype=_DTYPE[field.type],
                is_text=field.type == FieldDescriptor.TYPE_STRING,
                steps=on_path,
                is_ragged=is_ragged or field.is_repeated,
            )
