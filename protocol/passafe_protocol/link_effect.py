"""Effects of a link on messages, other than delay, and their counts."""

from typing import Final, NamedTuple, TypeAlias


class Effect(NamedTuple):
    """Effect of a link on one message.

    Attributes:
        effect: ``dropped``, ``duplicated`` or ``corrupted``.
        cause: Cause of a drop: ``loss``, ``queue`` or ``outage``; else empty.
    """

    effect: str
    cause: str = ""


Effects: TypeAlias = tuple[Effect, ...]

NO_EFFECT: Final[Effects] = ()
DROPPED_BY_LOSS: Final[Effects] = (Effect("dropped", "loss"),)
DROPPED_BY_QUEUE: Final[Effects] = (Effect("dropped", "queue"),)
DROPPED_BY_OUTAGE: Final[Effects] = (Effect("dropped", "outage"),)
DUPLICATED: Final[Effects] = (Effect("duplicated"),)
CORRUPTED: Final[Effects] = (Effect("corrupted"),)

EFFECTS: Final = ("dropped", "duplicated", "corrupted")
CAUSES: Final = ("loss", "queue", "outage")


class LinkCounts(NamedTuple):
    """Messages of a link since its start: entered + duplicated = delivered + dropped + in flight, at any time.

    Attributes:
        entered: Messages that entered the link.
        delivered: Messages and copies that left the link.
        dropped_loss: Messages lost at random.
        dropped_queue: Messages dropped at a full queue.
        dropped_outage: Messages dropped during an outage.
        duplicated: Copies made.
        corrupted: Messages and copies with a flipped bit, delivered or in flight.
        in_flight: Messages and copies still in the link.
    """

    entered: int
    delivered: int
    dropped_loss: int
    dropped_queue: int
    dropped_outage: int
    duplicated: int
    corrupted: int
    in_flight: int

    @property
    def dropped(self) -> int:
        """Messages dropped, whatever the cause."""
        return self.dropped_loss + self.dropped_queue + self.dropped_outage
