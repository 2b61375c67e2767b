"""Scheduled change of an injected link's settings."""

from dataclasses import dataclass

from passafe_protocol.link_settings import LinkSettings


@dataclass(frozen=True, kw_only=True, slots=True)
class LinkChange:
    """Change of a link's settings, scheduled before the run.

    Attributes:
        at_s: Time of the change, s after the first step of the process that reads the link.
        link: Name of the link.
        settings: Settings from then on.
    """

    at_s: float
    link: str
    settings: LinkSettings
