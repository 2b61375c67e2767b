"""The verdict on a run that is not over, from what a page has counted: the review's properties, the review's words."""

from typing import Final

from passafe_services.scenarios.schema import Scenario
from passafe_services.tools.review.between_samples import RecomputedMargins
from passafe_services.tools.review.drive_record import DriveRecord
from passafe_services.tools.review.extremum import Extremum
from passafe_services.tools.review.fallback_record import FallbackRecord
from passafe_services.tools.review.properties import Tolerances, judge_margins
from passafe_services.tools.review.property import Property

TOLERANCES: Final = Tolerances(h=1e-12)
"""Those of a page: it does not bound the rounding of every value of a barrier, which is far below this."""


def properties_so_far(
    scenario: Scenario,
    fallbacks: FallbackRecord,
    drive: DriveRecord,
    *,
    h_min: Extremum | None,
    h_possible: Extremum | None,
    power_margin_min: Extremum | None,
    tank_min_j: Extremum | None,
) -> dict[str, Property]:
    """Return the properties that can be judged without a log, by name, in the order of a review.

    Args:
        scenario: What is run.
        fallbacks: Its fallbacks so far.
        drive: What moved the robot so far.
        h_min: Smallest barrier value so far.
        h_possible: Smallest of those below 0 with the error of the states as read added; ``None``: they have none.
        power_margin_min: Smallest power margin so far, W.
        tank_min_j: Smallest energy of the tank so far, J.
    """
    margins = RecomputedMargins(
        h_min=h_min, h_possible=h_possible, power_margin_min=power_margin_min, tank_min_j=tank_min_j
    )
    driving = {"no-fallback": fallbacks.property(), "driven": drive.property()}
    return driving | judge_margins(margins, scenario, TOLERANCES)
