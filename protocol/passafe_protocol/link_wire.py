"""Conversion between the settings of a link and their wire record."""

from passafe_protocol.link_settings import LinkSettings, Span
from passafe_protocol.messages import LinkOutage, LinkParameters
from passafe_protocol.shapes import shape_of

_SHARED = tuple(field for field in shape_of(LinkParameters).names if field != "outages")


def parameters_of(settings: LinkSettings) -> LinkParameters:
    """Return the wire record of settings, without recorded traces, which are not transmitted."""
    shared = {field: getattr(settings, field) for field in _SHARED}
    return LinkParameters(**shared, outages=tuple(LinkOutage(*span) for span in settings.outages_s))


def settings_of(
    parameters: LinkParameters, trace_s: tuple[float, ...] = (), delay_trace_s: tuple[Span, ...] = ()
) -> LinkSettings:
    """Return the settings of a wire record.

    Args:
        parameters: The record.
        trace_s: Trace of the settings.
        delay_trace_s: Trace of delays of the settings.

    Raises:
        LinkSettingsError: A setting is outside its range, or two settings contradict each other.
    """
    shared = {field: getattr(parameters, field) for field in _SHARED}
    outages_s = tuple((outage.start_s, outage.end_s) for outage in parameters.outages)
    return LinkSettings(**shared, outages_s=outages_s, trace_s=trace_s, delay_trace_s=delay_trace_s)
