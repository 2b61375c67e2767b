"""Errors of the wire.

* ``ProtocolError``
    * ``DecodeError``: bytes that are no message of this topic (truncated, garbage)
        * ``ChecksumError``: bytes that are not those that were sent
    * ``SchemaVersionError``: a message of another version of ``passafe.proto``
    * ``InvalidMessageError``: decoded, but a field holds what it may not (NaN, inf, wrong shape, …)
    * ``LinkSettingsError``: a link's setting outside its range
"""

from reprlib import repr as short


class ProtocolError(Exception):
    """Anything wrong with what crosses the wire."""


class DecodeError(ProtocolError):
    """Bytes that are no message of the topic.

    Attributes:
        topic: Name of the topic that they arrived on.
        size: Their number.
    """

    def __init__(self, topic: str, size: int, reason: str) -> None:
        self.topic = topic
        self.size = size
        super().__init__(f"{topic}: {size} bytes are no message of this topic: {reason}")


class ChecksumError(DecodeError):
    """Bytes that do not end with the checksum of what stands before it: damaged, or from no sender of ours."""

    def __init__(self, topic: str, size: int) -> None:
        super().__init__(topic, size, "the checksum is missing or another")


class SchemaVersionError(ProtocolError):
    """A message of another schema version.

    Attributes:
        topic: Name of the topic.
        got: Version in the message.
        allowed: Version that this build speaks.
    """

    def __init__(self, topic: str, got: int, allowed: int) -> None:
        self.topic = topic
        self.got = got
        self.allowed = allowed
        super().__init__(f"{topic}: schema_version {got}, allowed {allowed}")


class InvalidMessageError(ProtocolError):
    """A decoded message with a field that may not hold what it holds.

    Attributes:
        topic: Name of the topic.
        field: Name of the field.
        got: Its value.
        allowed: What is allowed, in words.
    """

    def __init__(self, topic: str, field: str, got: object, allowed: str) -> None:
        self.topic = topic
        self.field = field
        self.got = got
        self.allowed = allowed
        super().__init__(f"{topic}.{field}: got {short(got)}, allowed {allowed}")


class LinkSettingsError(ProtocolError):
    """A link setting outside its range.

    Attributes:
        field: Name of the setting.
        got: Its value.
        allowed: What is allowed, in words.
    """

    def __init__(self, field: str, got: object, allowed: str) -> None:
        self.field = field
        self.got = got
        self.allowed = allowed
        super().__init__(f"link {field}: got {short(got)}, allowed {allowed}")
