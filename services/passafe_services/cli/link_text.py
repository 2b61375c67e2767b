"""Reads and prints settings of links as a user types them: ``delay=0.2,loss=0.1``."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any, Final

from passafe_protocol.link_settings import LinkSettings
from passafe_protocol.link_wire import parameters_of, settings_of
from passafe_protocol.messages import LinkParameters, LinkState
from pydantic import ValidationError

from passafe_services.cli.errors import OptionError
from passafe_services.scenarios.field_problems import problems_of
from passafe_services.scenarios.link_schema import LinkFields, ScenarioLink
from passafe_services.suggestion import suggestion

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
    "network": "network",
    "seed": "seed",
}
"""Field behind each key."""

_TEXTS: Final = frozenset({"distribution", "network", "trace"})
_FLAGS: Final = {"true": True, "false": False}
_BETWEEN: Final = "+"


def link_fields(parts: Iterable[str], where: str) -> dict[str, Any]:
    """Return the fields of a link's settings that ``KEY=VALUE`` texts set; what is no number stays a text.

    Several outages are joined by ``+`` (``outage=2:2.5+5:6``), quantiles too (``quantiles=0.01+0.02+0.1``).

    Args:
        parts: The texts.
        where: The option or argument that held them, for the message.

    Raises:
        OptionError: A text of another form, an unknown key, or one that comes twice.
    """
    fields: dict[str, Any] = {}
    for part in parts:
        key, equals, value = part.partition("=")
        if key not in LINK_KEYS or not equals:
            near = suggestion(key, LINK_KEYS) if key not in LINK_KEYS else ""
            raise OptionError(where, repr(part), f"KEY=VALUE with one of {', '.join(LINK_KEYS)}{near}")
        if LINK_KEYS[key] in fields:
            raise OptionError(where, f"{key} again: {part!r}", "each setting once")
        fields[LINK_KEYS[key]] = _value(key, value)
    return fields


def require_ranges(fields: Mapping[str, Any], where: str) -> None:
    """Require that each field by itself holds what it may.

    Args:
        fields: What ``link_fields`` returned.
        where: The option or argument that held them, for the message.

    Raises:
        OptionError: A value that a setting cannot have.
    """
    try:
        LinkFields.model_validate(fields)
    except ValidationError as error:
        raise _option_error(error, where) from error


def changed_parameters(before: LinkSettings, fields: Mapping[str, Any], where: str) -> LinkParameters:
    """Return settings with some of them changed.

    Args:
        before: The settings.
        fields: What ``link_fields`` returned.
        where: The option or argument that held them, for the message.

    Raises:
        OptionError: A value that a setting cannot have, or settings that exclude one another.
    """
    values = asdict(before)
    del values["trace_s"], values["delay_trace_s"]
    try:
        return parameters_of(ScenarioLink.model_validate(values | dict(fields)).settings())
    except ValidationError as error:
        raise _option_error(error, where) from error


def settings_text(state: LinkState) -> str:
    """Return the settings of a link that differ from the defaults, as a user would type them."""
    settings, default = settings_of(state.parameters), LinkSettings()
    parts = [
        f"{key}={_text(key, getattr(settings, field))}"
        for key, field in LINK_KEYS.items()
        if field != "trace" and getattr(settings, field) != getattr(default, field)
    ]
    if state.trace_opportunities:
        parts.append(f"trace of {state.trace_opportunities} times")
    return " ".join(parts) or "unimpaired"


def _option_error(error: ValidationError, where: str) -> OptionError:
    first, *more = problems_of(error, ScenarioLink)
    allowed = "; ".join([first.allowed, *map(str, more)])
    return OptionError(where, f"{first.field} {first.got}", allowed)


def _text(key: str, value: object) -> str:
    if key == "outage" and isinstance(value, tuple):
        return _BETWEEN.join(f"{start_s:g}:{end_s:g}" for start_s, end_s in value)
    if key == "quantiles" and isinstance(value, tuple):
        return _BETWEEN.join(f"{quantile_s:g}" for quantile_s in value)
    return f"{value:g}" if isinstance(value, float) else str(value).lower()


def _value(key: str, text: str) -> object:
    if key in _TEXTS:
        return text
    if key == "outage":
        return [[_plain(end) for end in span.split(":")] for span in text.split(_BETWEEN)] if text else []
    if key == "quantiles":
        return [_plain(each) for each in text.split(_BETWEEN)] if text else []
    return _plain(text)


def _plain(text: str) -> bool | int | float | str:
    if text in _FLAGS:
        return _FLAGS[text]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
