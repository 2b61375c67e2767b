"""Protobuf schemas as logs and viewers take them, also of message types that are made at run time."""

from collections.abc import Sequence
from typing import Any, Final

from google.protobuf import descriptor_pool, message_factory
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.message import Message as ProtobufMessage

from passafe_services.tables.columns import Column, Kind

_TYPES: Final[dict[Kind, FieldDescriptorProto.Type.ValueType]] = {
    "float": FieldDescriptorProto.TYPE_DOUBLE,
    "int": FieldDescriptorProto.TYPE_INT64,
    "uint": FieldDescriptorProto.TYPE_UINT64,
    "bool": FieldDescriptorProto.TYPE_BOOL,
    "text": FieldDescriptorProto.TYPE_STRING,
}


def descriptor_set(message_type: type[ProtobufMessage]) -> bytes:
    """Return the schema of a message type with all that it refers to, as a serialized ``FileDescriptorSet``."""
    found: dict[str, Any] = {}

    def add(file: Any) -> None:  # noqa: ANN401 - a descriptor of one of protobuf's implementations
        if file.name not in found:
            for dependency in file.dependencies:
                add(dependency)
            found[file.name] = file

    add(message_type.DESCRIPTOR.file)
    descriptors = FileDescriptorSet()
    for file in found.values():
        file.CopyToProto(descriptors.file.add())
    return descriptors.SerializeToString(deterministic=True)


def message_type_of(name: str, columns: Sequence[Column]) -> type[Any]:
    """Return a message type ``passafe.table.NAME`` with a field for each column, made at run time.

    Syntax proto2: an absent number is absent, and names that differ in an underscore alone are different.

    Args:
        name: Name of the message.
        columns: The fields, in order.
    """
    file = FileDescriptorProto(name=f"passafe/table/{name}.proto", package="passafe.table", syntax="proto2")
    message = file.message_type.add(name=name)
    for number, column in enumerate(columns, start=1):
        message.field.add(
            name=column.name,
            json_name=column.name,
            number=number,
            type=_TYPES[column.kind],
            label=FieldDescriptorProto.LABEL_OPTIONAL,
        )
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(f"passafe.table.{name}"))
