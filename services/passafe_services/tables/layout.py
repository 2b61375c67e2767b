"""Layout of a topic's table: which columns its messages fill, as far as they have been seen.

Numbers of a vector become ``x_1``, ``x_2``, …; parts with a name of their own become columns that carry it, such as
``barrier_disk_psi_0``. Only these can be more in a later message than in those before it: a layout grows.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from functools import cache
from math import nan
from typing import Any, Final, TypeAlias

from google.protobuf.descriptor import FieldDescriptor
from passafe_protocol import passafe_pb2
from passafe_protocol.messages import (
    BarrierReport,
    FilterTick,
    Header,
    Message,
    PlantInput,
    PlantState,
    Record,
    RowReport,
    TopicHealth,
)
from passafe_protocol.shapes import RecordType, Shape, shape_of
from passafe_protocol.topics import Topic

from passafe_services.tables.columns import Column, Kind, unit_in

NAMED: Final[dict[RecordType, tuple[str, str]]] = {
    BarrierReport: ("barrier", "name"),
    RowReport: ("row", "name"),
    TopicHealth: ("topic", "topic"),
}
"""Records in lists that have a name: what they are called in a column, and the field with the name."""

FIRST_INDEX: Final = {"psi": 0}
"""Index of a vector's first number where it is not 1: ψ₀ is h."""

Value: TypeAlias = Any
"""Value of a field: of the type that the field has in its record."""

REPEATED: Final = ("previous_u",)
"""Vectors that repeat what earlier messages had; only their length is kept."""

PLANT_TIMES: Final[dict[RecordType, str]] = {
    PlantState: "plant_ns",
    FilterTick: "effective_plant_ns",
    PlantInput: "effective_plant_ns",
}
"""Field with the plant time of a message; the column ``plant_s`` has it in seconds."""

_KINDS: Final[dict[int, Kind]] = {
    FieldDescriptor.CPPTYPE_DOUBLE: "float",
    FieldDescriptor.CPPTYPE_BOOL: "bool",
    FieldDescriptor.CPPTYPE_STRING: "text",
    FieldDescriptor.CPPTYPE_ENUM: "text",
    FieldDescriptor.CPPTYPE_INT32: "int",
    FieldDescriptor.CPPTYPE_INT64: "int",
    FieldDescriptor.CPPTYPE_UINT32: "uint",
    FieldDescriptor.CPPTYPE_UINT64: "uint",
}


class TableLayout:
    """Columns of one topic's table, which grow with the messages noted.

    Args:
        topic: The topic.

    Attributes:
        topic: The topic.
    """

    def __init__(self, topic: Topic) -> None:
        self.topic = topic
        self._units: Mapping[str, str] = {}
        self._header = _Part("header", shape_of(Header))
        self._body = _Part("", shape_of(topic.body))
        self._plant_time = PLANT_TIMES.get(topic.body)
        self._columns: tuple[Column, ...] | None = None

    def note(self, body: Message) -> bool:
        """Take up what a message has; return whether the table has more columns than before."""
        grown = self._body.note(body)
        if grown:
            self._columns = None
        return grown

    def name_units(self, units: Mapping[str, str]) -> None:
        """Give the columns their units: by stem of a name, see ``passafe_services.tables.units``."""
        self._units, self._columns = units, None

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns so far; a later layout has these and more."""
        if self._columns is None:
            found = [Column("time_s", "float", "s"), Column("log_ns", "uint", "ns")]
            found += [Column("plant_s", "float", "s")] if self._plant_time else []
            found += [*self._body.columns("", self._units), *self._header.columns("", self._units)]
            self._columns = tuple(_with_different_names(found))
        return self._columns

    def row(self, log_ns: int, start_ns: int, header: Header, body: Message) -> list[Any]:
        """Return the values of a message that was noted, in the order of the columns.

        Args:
            log_ns: Its log time.
            start_ns: Log time at which ``time_s`` is zero.
            header: Its header.
            body: Its body.
        """
        row: list[Any] = [(log_ns - start_ns) * 1e-9, log_ns]
        if self._plant_time:
            row.append(getattr(body, self._plant_time) * 1e-9)
        self._body.put(row, body)
        self._header.put(row, header)
        return row


class _Field(ABC):
    """A field of a record and the columns that it fills."""

    grows = True

    def __init__(self, name: str) -> None:
        self.name = name

    def note(self, value: Value) -> bool:
        """Take up what a value has; return whether there are more columns than before."""
        del value
        return False

    @abstractmethod
    def columns(self, prefix: str, units: Mapping[str, str]) -> Iterable[Column]:
        """Yield the columns, their names behind a prefix."""

    @abstractmethod
    def put(self, row: list[Any], value: Value) -> None:
        """Append the values of the columns to a row."""


class _Scalar(_Field):
    grows = False

    def __init__(self, name: str, kind: Kind) -> None:
        super().__init__(name)
        self._kind: Kind = kind

    def columns(self, prefix: str, units: Mapping[str, str]) -> Iterable[Column]:
        name = prefix + self.name
        yield Column(name, self._kind, unit_in(name) or units.get(name, ""))

    def put(self, row: list[Any], value: Value) -> None:
        row.append(value)


class _Enum(_Scalar):
    def put(self, row: list[Any], value: Value) -> None:
        row.append(value.name)


class _Count(_Field):
    """Number of entries of a list whose entries have no name."""

    grows = False

    def columns(self, prefix: str, units: Mapping[str, str]) -> Iterable[Column]:
        del units
        yield Column(f"{prefix}{self.name}_count", "uint")

    def put(self, row: list[Any], value: Value) -> None:
        row.append(len(value))


class _VectorField(_Field):
    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._width = 0

    def note(self, value: Value) -> bool:
        if len(value) <= self._width:
            return False
        self._width = len(value)
        return True

    def columns(self, prefix: str, units: Mapping[str, str]) -> Iterable[Column]:
        first, name = FIRST_INDEX.get(self.name, 1), prefix + self.name
        for k in range(first, first + self._width):
            yield Column(f"{name}_{k}", "float", units.get(f"{name}_{k}", units.get(name, unit_in(name))))

    def put(self, row: list[Any], value: Value) -> None:
        row.extend(value)
        row.extend([nan] * (self._width - len(value)))


class _Part(_Field):
    """A record within a message, or the message itself."""

    def __init__(self, name: str, shape: Shape, leave_out: str = "") -> None:
        super().__init__(name)
        self._read = shape.read
        self._fields = [(k, _field(shape, k)) for k, field in enumerate(shape.names) if field != leave_out]
        self._growing = [(k, field) for k, field in self._fields if field.grows]
        self.grows = bool(self._growing)

    def note(self, value: Value) -> bool:
        values = self._read(value)
        grown = [field.note(values[k]) for k, field in self._growing]
        return any(grown)

    def columns(self, prefix: str, units: Mapping[str, str]) -> Iterable[Column]:
        inner = f"{prefix}{self.name}_" if self.name else prefix
        for _, field in self._fields:
            yield from field.columns(inner, units)

    def put(self, row: list[Any], value: Value) -> None:
        values = self._read(value)
        for k, field in self._fields:
            field.put(row, values[k])


class _NamedList(_Field):
    """List of records with names; every number of each becomes a column of floats, not a number where it is absent."""

    def __init__(self, shape: Shape) -> None:
        word, self._key = NAMED[shape.record_type]
        super().__init__(word)
        self._shape = shape
        self._parts: dict[str, _Part] = {}

    def note(self, value: Value) -> bool:
        grown = False
        for record in value:
            name = getattr(record, self._key)
            if name not in self._parts:
                self._parts[name] = _Part(_word(name), self._shape, leave_out=self._key)
                grown = True
            grown |= self._parts[name].note(record)
        return grown

    def columns(self, prefix: str, units: Mapping[str, str]) -> Iterable[Column]:
        for name, part in self._parts.items():
            for column in part.columns(f"{prefix}{self.name}_", {}):
                stem = column.name.removeprefix(f"{prefix}{self.name}_{part.name}_")
                unit = units.get(f"{self.name} {name} {stem}", units.get(f"{self.name} {stem}", column.unit))
                yield Column(column.name, "float", unit)

    def put(self, row: list[Any], value: Value) -> None:
        records: dict[str, Record] = {getattr(record, self._key): record for record in value}
        for name, part in self._parts.items():
            record = records.get(name)
            if record is None:
                row.extend([nan] * sum(1 for _ in part.columns("", {})))
            else:
                part.put(row, record)


def _field(shape: Shape, k: int) -> _Field:
    name = shape.names[k]
    for index, _, element in shape.lists:
        if index == k:
            return _NamedList(element) if element.record_type in NAMED else _Count(name)
    for index, _, part in shape.parts:
        if index == k:
            return _Part(name, part)
    if any(index == k for index, _ in shape.vectors):
        return _Count(name) if name in REPEATED else _VectorField(name)
    is_enum = any(index == k for index, _, _ in shape.enums)
    return (_Enum if is_enum else _Scalar)(name, _kind(shape.record_type, name))


@cache
def _kind(record_type: RecordType, field: str) -> Kind:
    """Return the kind of a field as ``passafe.proto`` has it: Python does not tell signed from unsigned."""
    descriptor = getattr(passafe_pb2, record_type.__name__).DESCRIPTOR
    return _KINDS[descriptor.fields_by_name[field].cpp_type]


def _word(name: str) -> str:
    """Return a name as part of a column's name."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_") or "unnamed"


def _with_different_names(columns: Iterable[Column]) -> Iterable[Column]:
    """Yield columns, those whose name another has with a number behind it: names may differ in a dash alone."""
    seen: dict[str, int] = {}
    for column in columns:
        times = seen[column.name] = seen.get(column.name, 0) + 1
        yield column if times == 1 else column._replace(name=f"{column.name}__{times}")
