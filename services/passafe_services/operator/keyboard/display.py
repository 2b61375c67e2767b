"""Display of the operator: one line."""

from typing import NamedTuple

from passafe_protocol.messages import FilterStatus, Vector


class OperatorView(NamedTuple):
    """Data of the display; ``None`` where no recent message is known.

    Attributes:
        u_h: The command being sent, units of u.
        enabled: Whether the dead-man switch is held.
        holder: Other operator session that holds the lease, so that this one sends nothing; empty: none.
        stop_source: Process that pressed the emergency stop that is latched; empty: none is.
        position: First m states of the plant, the robot's position in every shipped model.
        status: Status of the filter.
        nearest: Name and h of the barrier with the smallest h; its limit is h = 0.
    """

    u_h: Vector
    enabled: bool
    holder: str
    stop_source: str
    position: Vector | None
    status: FilterStatus | None
    nearest: tuple[str, float] | None


def line(view: OperatorView, columns: int) -> str:
    """Return ``view`` as one line of at most ``columns`` characters, ASCII only."""
    if view.stop_source:
        text = f"EMERGENCY STOP by {_printable(view.stop_source)}: clear it on the page or with `passafe clear`"
    elif view.holder:
        text = f"WAITING: t takes over, q ends; operator {_printable(view.holder)} holds the lease"
    else:
        parts = (
            "HELD    " if view.enabled else "released",
            f"u_h {_numbers(view.u_h)}",
            "robot ?" if view.position is None else f"robot {_numbers(view.position)}",
            "filter ?" if view.status is None else f"filter {view.status.name:<11}",
            "" if view.nearest is None else f"h({_printable(view.nearest[0])}) {view.nearest[1]:+.3f}",
        )
        text = "  ".join(part for part in parts if part)
    return text[: max(columns, 0)]


def _numbers(vector: Vector) -> str:
    return "(" + ", ".join(f"{number:+7.2f}" for number in vector) + ")"


def _printable(name: str) -> str:
    """Replace non-printable characters of a received name, which could otherwise control the terminal."""
    return "".join(letter if letter.isascii() and letter.isprintable() else "?" for letter in name)
