"""A planned change of an injected link's settings."""

from dataclasses import dataclass

from passafe_protocol.link_settings import LinkSettings


@dataclass(frozen=True, kw_only=True, slots=True)
class LinkChange:
    """A change of a link's settings, planned before the run.

    Attributes:
        at_s: When, s after the first step of the process that reads the link.
        link: Name of the link.
        settings: What is in force from then on.
    """

    at_s: float
    link: str
    settings: LinkSettings
