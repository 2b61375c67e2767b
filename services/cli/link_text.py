"""Settings of links as a user types them: ``delay=0.2,loss=0.1``."""

from collections.abc import Iterable
from typing import Any, Final

from services.cli.errors import OptionError

LINK_KEYS: Final = {
    "delay": "delay_s",
    "jitter": "jitter_s",
    "distribution": "distribution",
    "quantiles": "quantiles_s",
    "correlation": "correlation",
    "reorder": "reorder",
    "loss": "loss",
    "burst-enter": "burst_enter",
    "burst-leave": "burst_leave",
    "burst-loss-good": "burst_loss_good",
    "burst-loss-bad": "burst_loss_bad",
    "duplicate": "duplicate",
    "corrupt": "corrupt",
    "rate": "rate_hz",
    "queue": "queue",
    "outage": "outages_s",
    "trace": "trace",
    "seed": "seed",
}
"""Field behind each key."""

_BETWEEN: Final = "+"


def link_fields(parts: Iterable[str], where: str) -> dict[str, Any]:
    """Return the fields of a link's settings that ``KEY=VALUE`` texts set, values still as text where they are one.

    Several outages are joined by ``+`` (``outage=2:2.5+5:6``), quantiles too (``quantiles=0.01+0.02+0.1``).

    Args:
        parts: The texts.
        where: What the user gave them with, for the message.

    Raises:
        OptionError: A text of another form, or an unknown key.
    """
    fields: dict[str, Any] = {}
    for part in parts:
        key, equals, value = part.partition("=")
        if key not in LINK_KEYS or not equals:
            raise OptionError(where, repr(part), f"KEY=VALUE with one of {', '.join(LINK_KEYS)}")
        fields[LINK_KEYS[key]] = _value(key, value)
    return fields


def _value(key: str, text: str) -> object:
    if key == "outage":
        return [span.split(":") for span in text.split(_BETWEEN)] if text else []
    if key == "quantiles":
        return text.split(_BETWEEN) if text else []
    return text
