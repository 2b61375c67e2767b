"""Schema of the links in scenario files."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self

from passafe_protocol.errors import LinkSettingsError
from passafe_protocol.link_settings import LinkSettings
from pydantic import Field, ValidationError, field_serializer, model_validator

from passafe_services.scenarios.fields import Config, NonNegative
from passafe_services.scenarios.link_trace import NO_TRACE, LinkTrace

LinkName = Literal["operator-to-filter", "filter-to-plant", "plant-to-filter", "plant-to-operator"]

NetworkName = Literal[
    "",
    "leo-moving",
    "leo-moving-obstructed",
    "leo-reconfiguring",
    "lte-driving",
    "5g-driving",
    "aircraft-calm",
    "aircraft-rough",
    "transcontinental-15ms",
    "transcontinental-114ms",
    "transcontinental-134ms",
    "transcontinental-160ms",
]

Delay = Annotated[float, Field(ge=0, le=10)]
Probability = Annotated[float, Field(ge=0, le=1)]
Moment = Annotated[float, Field(ge=0, le=1e6)]


class LinkFields(Config):
    """Settings of an injected link; ``docs/links.md`` explains each.

    Attributes:
        delay_s: Constant part of the delay, s.
        jitter_s: Half width of a uniform random part, else its standard deviation, s.
        distribution: Of the random part.
        quantiles_s: Of a histogram: delays at equal steps of probability, s.
        correlation: Rank correlation of successive delays.
        reorder: Whether messages may overtake one another.
        loss: Probability of an independent loss.
        burst_enter: Gilbert–Elliott: probability of entering the bad state.
        burst_leave: Probability of leaving it.
        burst_loss_good: Probability of a loss in the good state.
        burst_loss_bad: Probability of a loss in the bad state.
        duplicate: Probability of a copy.
        corrupt: Probability that one bit is flipped.
        rate_hz: Messages per second through the bottleneck; 0: no limit.
        queue: Messages that may wait there.
        outages_s: Start and end of each outage, s from the first message.
        trace: CSV file, repeated: of times at which the link lets one message through, in ms without a header, as
            Mahimahi has it, otherwise as the header says (``time_s`` or ``time_ms``); or of recorded delays, with a
            header ``sent_s,delay_s`` (or ``_ms``) and ``lost`` in the place of a delay.
        network: Model of a real network, by name, on top of the other settings; ``docs/networks.md`` has them all.
        seed: Of its random sequences.
    """

    delay_s: Delay = 0.0
    jitter_s: Delay = 0.0
    distribution: Literal["uniform", "normal", "pareto", "pareto-normal", "histogram"] = "uniform"
    quantiles_s: tuple[Delay, ...] = ()
    correlation: Annotated[float, Field(ge=0, le=0.9999)] = 0.0
    reorder: bool = True
    loss: Probability = 0.0
    burst_enter: Probability = 0.0
    burst_leave: Probability = 1.0
    burst_loss_good: Probability = 0.0
    burst_loss_bad: Probability = 1.0
    duplicate: Probability = 0.0
    corrupt: Probability = 0.0
    rate_hz: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    queue: Annotated[int, Field(ge=1, le=1_000_000)] = 1000
    outages_s: tuple[tuple[Moment, Moment], ...] = ()
    trace: str | None = None
    network: NetworkName = ""
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 1


class ScenarioLink(LinkFields):
    """Settings of one link, checked together."""

    @model_validator(mode="after")
    def _go_together(self) -> Self:
        try:
            self.settings()
        except LinkSettingsError as error:
            raise ValueError(f"{error.field}: got {error.got}, allowed {error.allowed}") from error
        if self.trace is not None and self.rate_hz:
            raise ValueError(f"rate_hz: got {self.rate_hz:g}, allowed 0 if there is a trace")
        return self

    def settings(self, trace: LinkTrace = NO_TRACE) -> LinkSettings:
        """Return the settings for ``Link``.

        Args:
            trace: Contents of the file ``trace``.

        Raises:
            LinkSettingsError: The trace does not go with the other settings.
        """
        return LinkSettings(**self.model_dump(exclude={"trace"}), **trace._asdict())


class LinkChangeConfig(Config):
    """One planned change of a link.

    Attributes:
        at_s: When, s after the first step of the process that reads the link.
        link: Which link.
        settings: What changes; other settings stay.
    """

    at_s: NonNegative
    link: LinkName
    settings: LinkFields

    @field_serializer("settings")
    def _only_what_changes(self, settings: LinkFields) -> dict[str, Any]:
        return settings.model_dump(exclude_unset=True)


def changed_links(
    links: Mapping[LinkName, ScenarioLink], changes: Sequence[LinkChangeConfig]
) -> list[tuple[LinkChangeConfig, ScenarioLink]]:
    """Return every change in order of time, with all settings in force from then on.

    Raises:
        ValueError: Settings contradict each other.
    """
    in_force = dict(links)
    changed = []
    for change in sorted(changes, key=lambda change: change.at_s):
        before = in_force.get(change.link, ScenarioLink())
        after = before.model_dump() | change.settings.model_dump(exclude_unset=True)
        try:
            in_force[change.link] = ScenarioLink.model_validate(after)
        except ValidationError as error:
            why = error.errors()[0]["msg"].removeprefix("Value error, ")
            raise ValueError(f"link_changes: {change.link} at {change.at_s:g} s: {why}") from error
        changed.append((change, in_force[change.link]))
    return changed
