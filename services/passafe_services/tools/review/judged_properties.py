"""Properties of a run, judged at the end of its review."""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Final, Protocol

from passafe_protocol.topics import LINK_EVENT, TOPICS

from passafe_services.log.continuity import TopicCount
from passafe_services.tools.review.between_samples import RecomputedMargins
from passafe_services.tools.review.emergency_stops import driven_but_for_stops
from passafe_services.tools.review.input_origin import driven_by_the_filter
from passafe_services.tools.review.link_accounts import LinkAccount
from passafe_services.tools.review.properties import (
    CONTROL_TOPICS,
    Completeness,
    cut_short,
    judge_completeness,
    judge_links,
    judge_run,
)
from passafe_services.tools.review.property import Property
from passafe_services.tools.review.run_review import RunReview
from passafe_services.tools.review.trajectory import NS_PER_S

OF_THE_FILTER: Final = tuple(topic for topic in TOPICS if topic.recorded and topic.publishers == ("filter",))
"""Topics whose numbers begin when a filter does, and with it the run."""


class ReadLog(Protocol):
    """Log that was read to its end, in one pass or in memory."""

    @property
    def finished(self) -> bool:
        """True if its writer finished it, also before a recovery."""
        ...

    @property
    def shortcomings(self) -> Sequence[str]:
        """Reasons for which its checkpoints do not prove that nothing is missing, in words."""
        ...

    @property
    def counts(self) -> Mapping[str, TopicCount]:
        """Message counts of every topic, by its name."""
        ...


def judged_properties(
    review: RunReview, log: ReadLog, margins: RecomputedMargins, accounts: list[LinkAccount]
) -> dict[str, Property]:
    """Return the properties of a run by their names.

    Args:
        review: The review, which has taken the whole log.
        log: The log, read to its end.
        margins: Extrema of what was recomputed.
        accounts: Accounts of the links.
    """
    scenario, tolerances = review.identity.scenario, review.tolerances
    driven = driven_by_the_filter(review.drive.property(), review.origin.foreign())
    return {
        "no-fallback": review.decisions.fallbacks.property(),
        "driven": driven_but_for_stops(driven, review.plant.stops),
        **judge_run(
            scenario,
            margins,
            tolerances,
            bounded=review.limits.property(),
            certified=review.decisions.certified(required=scenario.filter.mode != "off"),
        ),
        **review.assumption(),
        **review.agreement(),
        "complete": judge_completeness(_completeness(review, log)),
        "links-reconciled": judge_links(accounts, has_events=log.counts[LINK_EVENT.name].received > 0),
    }


def _completeness(review: RunReview, log: ReadLog) -> Completeness:
    plant, period_s = review.plant, review.identity.scenario.dt_s
    counts = [log.counts[topic.name] for topic in CONTROL_TOPICS]
    walls = [count.first_gap_wall_ns for count in counts if count.first_gap_wall_ns is not None]
    moving = plant.moving
    first_s, lasted_s = ((moving[0].first_ns or 0) / NS_PER_S, moving[-1].last_ns / NS_PER_S) if moving else (inf, 0.0)
    waited = bool(moving) and next(iter(plant.sessions.values())).waited
    return Completeness(
        gaps=sum(count.gaps for count in log.counts.values())
        + sum(log.counts[topic.name].missed_at_start for topic in OF_THE_FILTER),
        out_of_order=sum(count.out_of_order for count in counts),
        contradicting=sum(count.contradicting for count in log.counts.values()),
        first_gap_s=plant.plant_s(min(walls)) if walls else None,
        is_finished=log.finished,
        shows_start=waited or first_s <= period_s,
        shortcomings=log.shortcomings,
        cut_short=cut_short(review.identity.planned_s, lasted_s, period_s) or plant.plants.in_words(),
    )
