"""Errors of the wire; the tree of all errors is in ``passafe.errors``."""

from typing import ClassVar

from passafe.errors import NotAllowedError, PassafeError


class ProtocolError(PassafeError):
    """Anything wrong with what crosses the wire."""


class DecodeError(ProtocolError):
    """Bytes that are no message of the topic: truncated, or garbage.

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


class InvalidMessageError(ProtocolError, NotAllowedError):
    """A decoded message with a field that may not hold what it holds.

    Attributes:
        topic: Name of the topic.
    """

    quotes_got: ClassVar[bool] = True

    def __init__(self, topic: str, field: str, got: object, allowed: str) -> None:
        self.topic = topic
        self.prefix = f"{topic}."
        super().__init__(field, got, allowed)


class SessionError(InvalidMessageError):
    """A valid message whose session is not the current one of its sender, or whose number is out of its reach."""


class SchemaVersionError(ProtocolError, NotAllowedError):
    """A message of another schema version.

    Attributes:
        topic: Name of the topic.
    """

    def __init__(self, topic: str, got: int, allowed: int) -> None:
        self.topic = topic
        self.prefix = f"{topic}."
        super().__init__("schema_version", got, str(allowed))


class RobotNameError(ProtocolError, NotAllowedError):
    """A name that no robot can have: it would not fit into key expressions and certificates."""

    quotes_got: ClassVar[bool] = True

    def __init__(self, got: str, allowed: str) -> None:
        super().__init__("robot", got, allowed)


class IdentityError(ProtocolError, NotAllowedError):
    """A role, a name or a certificate's common name that no process of ours can have."""

    quotes_got: ClassVar[bool] = True


class LinkSettingsError(ProtocolError, NotAllowedError):
    """A link setting outside its range."""

    prefix = "link "
    quotes_got: ClassVar[bool] = True
