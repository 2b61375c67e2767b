"""Messages about the injected links: settings, effects and counts."""

from passafe_protocol.messages.record import Record, Vector


class LinkOutage(Record, frozen=True):
    """Outage of a link; times from its first message."""

    start_s: float
    end_s: float


class LinkParameters(Record, frozen=True):
    """Settings of one injected link on the wire: see ``passafe_protocol.link_settings``."""

    delay_s: float
    jitter_s: float
    distribution: str
    quantiles_s: Vector
    correlation: float
    reorder: bool
    loss: float
    burst_enter: float
    burst_leave: float
    burst_loss_good: float
    burst_loss_bad: float
    duplicate: float
    corrupt: float
    rate_hz: float
    queue: int
    outages: tuple[LinkOutage, ...]
    seed: int
    network: str = ""


class LinkConfig(Record, frozen=True):
    """Request to change the settings of a link."""

    link: str
    parameters: LinkParameters


class LinkEvent(Record, frozen=True):
    """Effect of a link on one message, other than delay."""

    link: str
    effect: str
    topic: str
    sequence: int
    cause: str = ""


class LinkSource(Record, frozen=True):
    """Messages of one session of a sender that entered a link."""

    source: str
    epoch: int
    first: int
    newest: int
    received: int


class LinkState(Record, frozen=True):
    """Settings in force of one link and counts of its messages."""

    link: str
    topic: str
    parameters: LinkParameters
    trace_opportunities: int
    entered: int
    delivered: int
    dropped_loss: int
    dropped_queue: int
    dropped_outage: int
    duplicated: int
    corrupted: int
    in_flight: int
    refused_corrupted: int
    refused_duplicate: int
    trigger: str
    config_source: str
    config_epoch: int
    config_sequence: int
    refusal: str
    sources: tuple[LinkSource, ...]
