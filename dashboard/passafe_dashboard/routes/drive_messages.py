"""Messages that a page sends to drive: WebSocket ``/drive``, JSON text."""

from typing import Annotated, Any, Final, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

LONGEST_SHOWN: Final = 80
"""Characters of a refused value that the answer repeats."""

Milliseconds = Annotated[float, Field(ge=0.0, le=1e15, allow_inf_nan=False)]
Share = Annotated[float, Field(ge=-1.0, le=1.0, allow_inf_nan=False)]


class _PageMessage(BaseModel):
    """Base of all messages: unknown fields and values of other types are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Take(_PageMessage):
    """Ask to drive.

    Attributes:
        over: Whether to take it from another page or another operator.
    """

    type: Literal["take"]
    over: bool = False


class PageSteer(_PageMessage):
    """Command of the page, sent at 60 Hz while it drives.

    Attributes:
        number: Larger than that of every earlier command of this connection.
        shares: Share of the authority of each input.
        engaged: Whether the dead-man is held.
        echo_ms: ``server_ms`` of the newest clock message.
        held_ms: Time since that arrived, by the page's own clock.
    """

    type: Literal["steer"]
    number: Annotated[int, Field(ge=0, lt=2**53)]
    shares: Annotated[list[Share], Field(min_length=1, max_length=64)]
    engaged: bool
    echo_ms: Milliseconds
    held_ms: Milliseconds


class Release(_PageMessage):
    """Give the wheel back: nobody drives."""

    type: Literal["release"]


class Script(_PageMessage):
    """Hand the wheel to the scenario's own source of commands."""

    type: Literal["script"]


PageMessage: TypeAlias = Take | PageSteer | Release | Script

_ADAPTER: Final[TypeAdapter[PageMessage]] = TypeAdapter(Annotated[PageMessage, Field(discriminator="type")])


def parsed(text: str) -> PageMessage | dict[str, Any]:
    """Return the message of a text, or the answer that refuses it."""
    try:
        return _ADAPTER.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        what = ".".join(str(part) for part in first["loc"]) or "message"
        return refusal(what, first["input"], first["msg"])


def refusal(what: str, got: object, allowed: str) -> dict[str, Any]:
    """Return the answer to a message that is refused.

    Args:
        what: Field.
        got: Its value.
        allowed: What it may be.
    """
    return {"type": "refused", "what": what, "got": ascii(got)[:LONGEST_SHOWN], "allowed": allowed}
