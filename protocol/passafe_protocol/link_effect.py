"""What a link does to messages other than delaying them, and how many it did it to."""

from typing import Final, NamedTuple, TypeAlias


class Effect(NamedTuple):
    """One thing done to one message.

    Attributes:
        effect: ``dropped``, ``duplicated`` or ``corrupted``.
        cause: Why it was dropped: ``loss``, ``queue`` or ``outage``; else empty.
    """

    effect: str
    cause: str = ""


Effects: TypeAlias = tuple[Effect, ...]

UNHARMED: Final[Effects] = ()
LOST: Final[Effects] = (Effect("dropped", "loss"),)
OVERFLOWED: Final[Effects] = (Effect("dropped", "queue"),)
CUT: Final[Effects] = (Effect("dropped", "outage"),)
DUPLICATED: Final[Effects] = (Effect("duplicated"),)
CORRUPTED: Final[Effects] = (Effect("corrupted"),)

EFFECTS: Final = ("dropped", "duplicated", "corrupted")
CAUSES: Final = ("loss", "queue", "outage")


class LinkCounts(NamedTuple):
    """Messages of a link since its start: entered + duplicated = delivered + dropped + under way, at any moment.

    Attributes:
        entered: Messages that entered the link.
        delivered: Messages and copies that came out.
        dropped_loss: Messages lost at random.
        dropped_queue: Messages that found the queue full.
        dropped_outage: Messages that came during an outage.
        duplicated: Copies made.
        corrupted: Messages and copies with a bit flipped; they are delivered, or under way, like others.
        in_flight: Messages and copies that have not come out yet.
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
        """Messages that never come out."""
        return self.dropped_loss + self.dropped_queue + self.dropped_outage
