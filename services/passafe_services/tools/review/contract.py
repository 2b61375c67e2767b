"""Contract of a log: which properties, bounds and rates a verdict has to show, from a TOML file."""

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, ClassVar, Final

from passafe_protocol.topics import TOPIC_OF_NAME
from pydantic import AfterValidator, Field, ValidationError

from passafe_services.scenarios.bounded_file import require_bounded, why_unreadable
from passafe_services.scenarios.errors import ConfigurationError
from passafe_services.scenarios.field_problems import problems_of
from passafe_services.scenarios.fields import Config
from passafe_services.suggestion import suggestion
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.verdict import Verdict
from passafe_services.tools.review.verdict_words import AGREEMENT, EVIDENCE, decide, in_words

Number = Annotated[float, Field(allow_inf_nan=False)]
Count = Annotated[int, Field(ge=0)]
Positive = Annotated[float, Field(ge=0, allow_inf_nan=False)]

PROPERTIES: Final = (
    *("no-fallback", "driven", "safe", "protected-start", "passive", "energy", "bounded", "certified", "consistent"),
    "model",
    *AGREEMENT,
    *EVIDENCE,
)
"""Properties of every verdict; ``model`` of a scenario with sets alone."""


class ContractError(ConfigurationError):
    """A contract of a log with fields that hold what they may not."""

    noun: ClassVar[str] = "contract"


def known_property(name: str) -> str:
    """Return the name of a property of every verdict.

    Raises:
        ValueError: There is none of this name.
    """
    if name not in PROPERTIES:
        raise ValueError(f"{', '.join(PROPERTIES)}{suggestion(name, PROPERTIES)}")
    return name


def _known_topic(name: str) -> str:
    if name not in TOPIC_OF_NAME:
        raise ValueError(f"{', '.join(TOPIC_OF_NAME)}{suggestion(name, [*TOPIC_OF_NAME])}")
    return name


class TopicContract(Config):
    """Bounds for the messages of one topic.

    Attributes:
        rate_hz_at_least: Distinct messages per second of the run.
        rate_hz_at_most: The same, largest.
        gaps_at_most: Messages missing between others.
        missed_at_start_at_most: Messages missing before the first one.
        undecodable_at_most: Messages that are not valid.
    """

    rate_hz_at_least: Positive | None = None
    rate_hz_at_most: Positive | None = None
    gaps_at_most: Count | None = None
    missed_at_start_at_most: Count | None = None
    undecodable_at_most: Count | None = None


class LogContract(Config):
    """Bounds that a run has to keep, besides what its scenario requires; each may be left out.

    Attributes:
        require: Properties that are required, whatever the mode of the filter.
        duration_s_at_least: Plant time of the run, s.
        h_min_at_least: Smallest barrier value.
        power_margin_min_at_least: Smallest power margin, W.
        tank_min_j_at_least: Smallest energy of the tank, J.
        u_norm_max_at_most: Largest ‖u‖₂ in force.
        steps_skipped_at_most: Filter steps skipped to catch up.
        sequence_breaks_at_most: Stretches without an input of the filter.
        without_input_s_at_most: Their total length, s.
        solve_us_p99_at_most: 99th percentile of the filter's step, µs; live logs only.
        late_us_p99_at_most: 99th percentile of the lateness of filter steps, µs; live logs only.
        command_age_ms_p99_at_most: 99th percentile of the age of the newest command, ms.
        topics: Bounds by name of the topic.
    """

    require: tuple[Annotated[str, AfterValidator(known_property)], ...] = ()
    duration_s_at_least: Positive | None = None
    h_min_at_least: Number | None = None
    power_margin_min_at_least: Number | None = None
    tank_min_j_at_least: Number | None = None
    u_norm_max_at_most: Positive | None = None
    steps_skipped_at_most: Count | None = None
    sequence_breaks_at_most: Count | None = None
    without_input_s_at_most: Positive | None = None
    solve_us_p99_at_most: Positive | None = None
    late_us_p99_at_most: Positive | None = None
    command_age_ms_p99_at_most: Positive | None = None
    topics: dict[Annotated[str, AfterValidator(_known_topic)], TopicContract] = Field(default_factory=dict)


def load_contract(path: Path) -> LogContract:
    """Return the contract in a TOML file.

    Raises:
        ContractError: The file is missing or no TOML, or fields hold what they may not; all of them are named.
    """
    try:
        require_bounded(path)
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise ContractError(str(path), "file", why_unreadable(error), "a readable TOML file") from error
    try:
        return LogContract.of_file(data)
    except ValidationError as error:
        first, *more = problems_of(error, LogContract)
        raise ContractError(str(path), first.field, first.got, first.allowed, *more) from error


def under(verdict: Verdict, contract: LogContract) -> Verdict:
    """Return a verdict that holds only if the contract is kept, too; each bound becomes a property of its own."""
    properties = dict(verdict.properties)
    for name in contract.require:
        properties[name] = (properties.get(name) or _absent(name)).model_copy(update={"required": True})
    properties |= dict(_bounds(verdict, contract))
    changes = {"properties": properties, "verdict": decide(properties), "words": in_words(properties)}
    return verdict.model_copy(update=changes)


def _absent(name: str) -> Property:
    """Return a property that the review of this run does not have: nothing speaks for it."""
    note = f"{name} was required, and the scenario has nothing to judge it by"
    return Property(holds=None, required=True, worst=None, at_s=None, requirement=name, note=note)


def _bounds(verdict: Verdict, contract: LogContract) -> Iterator[tuple[str, Property]]:
    for field in LogContract.model_fields:
        limit = getattr(contract, field)
        if field not in ("require", "topics") and limit is not None:
            name = field.removesuffix("_at_least").removesuffix("_at_most")
            yield _bound(name, getattr(verdict, name), limit, is_least=field.endswith("_at_least"))
    for topic, asked in contract.topics.items():
        for field in TopicContract.model_fields:
            limit = getattr(asked, field)
            if limit is not None:
                name = field.removesuffix("_at_least").removesuffix("_at_most")
                found = _of_topic(verdict, topic, name)
                yield _bound(f"{topic}.{name}", found, limit, is_least=field.endswith("_at_least"))


def _of_topic(verdict: Verdict, topic: str, name: str) -> float | None:
    if name == "rate_hz":
        return verdict.received[topic] / verdict.duration_s if verdict.duration_s > 0 else None
    counts: dict[str, int] = getattr(verdict, name)
    return counts.get(topic, 0)


def _bound(name: str, found: float | None, limit: float, *, is_least: bool) -> tuple[str, Property]:
    sign = "≥" if is_least else "≤"
    holds = None if found is None else found >= limit if is_least else found <= limit
    return f"contract: {name}", Property(
        holds=holds,
        required=True,
        worst=None if found is None else float(found),
        at_s=None,
        requirement=f"{name} {sign} {limit:g}, by the contract",
        allowed=f"{sign} {limit:g}",
    )
