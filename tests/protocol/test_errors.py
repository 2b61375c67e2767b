"""Errors carry their evidence and say what, got and allowed."""

import pytest
from passafe_protocol.errors import (
    DecodeError,
    InvalidMessageError,
    LinkSettingsError,
    ProtocolError,
    SchemaVersionError,
)


@pytest.mark.parametrize(
    ("error", "text", "evidence"),
    [
        (
            DecodeError("state", 3, "no header"),
            "state: 3 bytes are no message of this topic: no header",
            {"topic": "state", "size": 3},
        ),
        (
            SchemaVersionError("state", 2, 1),
            "state.schema_version: got 2, allowed 1",
            {"topic": "state", "got": 2, "allowed": "1"},
        ),
        (
            InvalidMessageError("state", "x", (), "1 to 64 numbers"),
            "state.x: got (), allowed 1 to 64 numbers",
            {"topic": "state", "field": "x", "got": (), "allowed": "1 to 64 numbers"},
        ),
        (
            LinkSettingsError("loss", 2.0, "a number from 0 to 1"),
            "link loss: got 2.0, allowed a number from 0 to 1",
            {"field": "loss", "got": 2.0, "allowed": "a number from 0 to 1"},
        ),
    ],
)
def test_error_has_field_got_and_allowed(error: ProtocolError, text: str, evidence: dict[str, object]) -> None:
    assert isinstance(error, ProtocolError)
    assert str(error) == text
    assert {name: getattr(error, name) for name in evidence} == evidence


def test_a_huge_value_does_not_make_a_huge_message() -> None:
    error = InvalidMessageError("event", "text", "x" * 1_000_000, "less")

    assert len(str(error)) < 200
    assert len(error.got) == 1_000_000
